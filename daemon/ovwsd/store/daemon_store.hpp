/// The daemon's state store: a write queue in front of the state files. Reports items that cannot
/// be written.
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "daemon/ovwsd/actor/disk.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/store/state_store.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// State folder: `config.directory`, or else the first folder of $STATE_DIRECTORY; none if neither
/// is set.
std::optional<std::string> state_directory_of(const StateConfig& config);

/// Write-behind queue of state items, which the disk thread writes. An item whose write fails stays
/// queued and is retried every two seconds. Only the newest item of a kind and name is queued.
/// Thread-safe. Without a store the daemon still works, but saves nothing.
class DaemonStore {
 public:
  /// Callback with the result of a write: the item's checksum, or why the item is not stored yet.
  /// Called in the disk thread after the first attempt, and again if a later attempt succeeds. If
  /// there is no attempt, it is called in the caller's thread.
  using Tried = std::function<void(const Result<std::string>& kept)>;
  using Dropped = std::function<void(const Result<void>& dropped)>;
  /// Treatment of the previous file on the disk while the new item cannot be written.
  enum class Older {
    stays,
    set_aside,  ///< renamed, because a restart must not load outdated data
  };
  /// Memory limit of all queued items, bytes; an item that exceeds the limit is not stored.
  static constexpr std::size_t kMaxQueuedBytes = std::size_t{128} << 20;

  /// Opens the store in state_directory_of(config); blocks on the disk. Emits an event if no folder
  /// is configured, or if the folder is unusable or read-only. Items in a read-only folder are
  /// loaded. Without `disk`, the calling thread carries out every operation at once.
  DaemonStore(const StateConfig& config, Events& events, Disk* disk = nullptr);

  // Non-blocking methods, for any thread: they never wait for the disk.
  /// Queues the write of an item. `tried` gets the checksum, or an error. Errc::unavailable: there
  /// is no store, too much is queued, or the disk does not take it. Errc::refused: a newer item of
  /// this kind and name took its place in the queue.
  void put(std::string_view kind, std::string_view name, const nlohmann::json& content, Older older,
           Tried tried);
  /// Deletes an item, queued or on the disk, in one attempt. Errors: see remove_file; without a
  /// store the deletion succeeds.
  void drop(std::string_view kind, std::string_view name, Dropped dropped);
  /// Deletes several items; `dropped` is called once, with the first error.
  void drop_all(std::string_view kind, const std::vector<std::string>& names, Dropped dropped);
  /// Makes a callback for `put`. The callback emits an event of kind `kind` with the result for
  /// `title`. Then it calls `then` with the checksum, which is empty if the item is not stored.
  Tried reporting(std::string kind, std::string title, std::int64_t t_taken_ns,
                  std::function<void(const std::string& sha256)> then);
  StatusMessage::StorePart report() const;
  /// Runs `task` in the disk thread, after all tasks queued earlier. Errors: see Disk::request.
  Result<void> request(Disk::Task task);

  // Methods that read the disk in the calling thread, which then cannot be stopped: for the start
  // and for the disk thread.
  /// Finds the queued item, or else the item on the disk; none if neither exists.
  std::optional<StateItem> find(std::string_view kind, std::string_view name) const;
  /// Passes all items of a kind to `take`, queued or on the disk; see StateStore::load. Damaged
  /// files are not used; an event reports each.
  void load(std::string_view kind, const std::function<void(StateItem)>& take) const;

  /// Tries to write one queued item; called in the disk thread. True if another item is due.
  bool turn();
  /// Number of items that are not on the disk yet.
  int queued() const;

 private:
  struct Item {
    std::string kind, name;
    std::shared_ptr<const std::string> text;  ///< null: delete the item, or set it aside
    Older older = Older::stays;
    Tried tried;
    std::uint64_t number = 0;          ///< increases in the order of requests
    bool due = true;                   ///< try it in the next turn
    std::optional<std::string> why{};  ///< why the last attempt failed
    /// Queued write that this deletion displaced; it is queued again if the deletion fails.
    std::shared_ptr<const Item> displaced{};
    std::size_t bytes() const;
  };
  void queue(Item item);
  std::list<Item> take_out(const Item& newer);                        // call with mutex_ locked
  std::shared_ptr<const Item> write_before(const Item& newer) const;  // call with mutex_ locked
  Result<std::string> carry_out(const Item& item);
  Result<std::string> write(const Item& item);
  void settle(const Item& item, const Result<std::string>& done);  // call with mutex_ locked
  std::vector<Item> queued_of(std::string_view kind) const;
  bool any_due() const;  // call with mutex_ locked
  void make_all_due();   // call with mutex_ locked
  void wake();

  Events& events_;
  Disk* disk_;
  std::optional<StateStore> store_;  ///< not changed after the constructor
  std::optional<std::string> directory_, why_none_;

  mutable std::mutex mutex_;             ///< never held while the disk works
  std::list<Item> items_;                ///< oldest first
  std::optional<std::uint64_t> trying_;  ///< number of the item being written
  std::uint64_t last_number_ = 0;
  std::int64_t next_try_ns_ = 0;
  int refused_ = 0;                           ///< items failed since the queue was last empty
  std::optional<std::string> why_read_only_;  ///< cleared when a write succeeds
};

}  // namespace ovws
