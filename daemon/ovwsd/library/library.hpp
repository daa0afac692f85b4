/// The library: measured items that survive a restart, and the only way to their files. Items that
/// cannot be written wait and are reported.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/library/state_folder.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// A kind of items, and how messages call it.
struct ItemKind {
  const char *name, *event;    ///< of the files, of the events
  const char *title, *method;  ///< what it is, and what measures it
  /// Limit of stored items, whatever sensor and bench they belong to; the oldest is deleted first.
  /// 0: the owner limits them.
  std::size_t most = 0;
};
inline constexpr ItemKind kReferenceItems{"reference", "reference", "reference", "reference.take",
                                          16};
inline constexpr ItemKind kCalibrationItems{"calibration", "calibration", "calibration",
                                            "calibration.run", 16};
inline constexpr ItemKind kRegistrationItems{"registration", "registration", "registration",
                                             "registration.run"};
inline constexpr ItemKind kLutItems{"lut", "slm", "LUT", "lut.run"};
inline constexpr ItemKind kFlatnessItems{"flatness", "slm", "flatness", "flatness.run"};
inline constexpr ItemKind kSavedReferenceItems{"saved-reference", "reference", "saved reference",
                                               "reference.save"};
inline constexpr ItemKind kLatticeItems{"lattice", "lattice", "prepared lattice",
                                        "lattice.prepare"};

/// "the reference of 2026-01-31T12:00:00.000Z"
std::string title_of(const ItemKind& kind, std::int64_t t_taken_ns);

/// Write-behind queue of items, which the disk thread writes. An item whose write fails waits and
/// is written again every two seconds, until it is written, replaced or removed; meanwhile the
/// older file of its name is set aside, because a restart must not load outdated data. Thread-safe.
/// Without a folder the daemon still works, but saves nothing.
class Library {
 public:
  struct Item {
    const ItemKind* kind;
    std::string name;  ///< [a-z0-9_-]
    std::int64_t t_taken_ns = 0;
    nlohmann::json content;
    std::string title;                    ///< in events about its file; empty: none are emitted
    std::vector<std::string> replaces{};  ///< items of this kind to remove once it is written
    bool once = false;                    ///< if its write fails, it is not tried again
  };
  /// Called once, in the disk thread after the first attempt, with the checksum of the item's file
  /// or why it is not stored yet. If there is no attempt, called in the caller's thread.
  using Stored = std::function<void(const Result<std::string>& sha256)>;
  using Removed = std::function<void(const Result<void>& removed)>;
  /// Memory limit of all queued items, bytes; an item that exceeds the limit is not stored.
  static constexpr std::size_t kMaxQueuedBytes = std::size_t{128} << 20;

  /// Opens state_directory_of(config); blocks on the disk. Emits an event if no folder is
  /// configured, or if the folder is unusable or read-only. Items in a read-only folder are
  /// loaded. Without `disk`, the calling thread carries out every operation at once.
  Library(const StateConfig& config, Events& events, Disk* disk = nullptr);

  // Non-blocking methods, for any thread: they never wait for the disk.
  /// Queues the write of an item. Events report its first failure and its success. Errors passed to
  /// `stored`: Errc::unavailable: there is no folder, too much is queued, or the disk does not take
  /// it. Errc::refused: a newer request for this item took its place in the queue.
  void put(Item item, Stored stored = nullptr);
  /// Deletes items, queued or on the disk, in one attempt. Calls `removed` once, with the first
  /// error: see remove_file. An item that waited to be written then waits again. Without a folder,
  /// or if a new item of that name is put meanwhile, the deletion succeeds.
  void remove(const ItemKind& kind, const std::vector<std::string>& names, const Removed& removed);
  /// Checksum of the item's file; empty: the newest item of this name is not on the disk.
  std::string sha256(const ItemKind& kind, const std::string& name) const;
  /// Reports that a stored item was loaded, or why it is not used (`obstacle`).
  void publish_loaded(const ItemKind& kind, const std::string& name, std::int64_t t_taken_ns,
                      const std::string& obstacle);
  StatusMessage::StorePart report() const;
  int queued() const;  ///< number of items that are not on the disk yet
  /// Runs `task` in the disk thread, after all tasks queued earlier. Errors: see Disk::request.
  Result<void> request(Disk::Task task);

  // Methods that read the disk in the calling thread, which then cannot be stopped: for the start
  // and for the disk thread.
  /// Passes all items of a kind to `take`, sorted by name, and one at a time because they may be
  /// large. An event reports each file that is damaged or that `take` refuses, and it stays.
  void load(const ItemKind& kind, const std::function<Result<void>(const StateItem&)>& take);
  /// Reads one item. Errors: there is none of this name, or its file is damaged.
  Result<StateItem> read(const ItemKind& kind, const std::string& name) const;
  /// Errc::refused, field "name": there is a file of this name, though it may not be usable.
  Result<void> check_new(const ItemKind& kind, const std::string& name) const;

  /// Tries to write one queued item; called in the disk thread. True if another item is due.
  bool turn();

 private:
  using Key = std::pair<std::string, std::string>;  ///< kind and name
  /// What is to be done about one item.
  struct Work {
    std::shared_ptr<const Item> item;         ///< without its content; null: events are not emitted
    std::shared_ptr<const std::string> text;  ///< to be written; null: nothing is
    bool removes = false;                     ///< remove the item; if that fails, write `text`
    Stored done{};                            ///< null: answered
    std::uint64_t number = 0;                 ///< increases in the order of requests
    bool due = true;                          ///< try it in the next turn
    std::optional<std::string> why{};         ///< why the last attempt failed
    std::size_t bytes() const;
  };
  using Files = std::vector<std::pair<std::int64_t, std::string>>;  ///< time and name
  void add(const Key& key, Work work);                              // call with mutex_ locked
  void displace(Stored done, bool succeeds);                        // call with mutex_ locked
  void forget_file(const Key& key);                                 // call with mutex_ locked
  // Call with mutex_ locked.
  std::vector<std::string> count_file(const Key& key, std::int64_t t_taken_ns, std::size_t most);
  void wake();
  Result<std::string> carry_out(const Key& key, const Work& work);
  Result<std::string> write(const Key& key, const Work& work);
  void settle(const Key& key, const Work& work,
              const Result<std::string>& done);  // call with mutex_ locked
  void publish(const Work& work, const Result<std::string>& done);
  void remove_quietly(const ItemKind& kind, const std::vector<std::string>& names);
  bool any_due() const;  // call with mutex_ locked
  void make_all_due();   // call with mutex_ locked

  Events& events_;
  Disk* disk_;
  std::optional<StateFolder> folder_;  ///< not changed after the constructor
  std::optional<std::string> directory_, why_none_;

  mutable std::mutex mutex_;  ///< never held while the disk works
  std::map<Key, Work> queue_;
  /// Of requests that newer ones have replaced, with their results.
  std::vector<std::pair<Stored, Result<std::string>>> displaced_;
  std::map<Key, std::string> sums_;     ///< of files that hold the newest item
  std::map<std::string, Files> files_;  ///< usable ones of each kind
  std::uint64_t last_number_ = 0;
  std::int64_t next_try_ns_ = 0;
  bool waiting_ = false;                      ///< an item has failed since the queue was last empty
  std::optional<std::string> why_read_only_;  ///< cleared when a write succeeds
};

}  // namespace ovws
