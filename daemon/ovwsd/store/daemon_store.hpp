/// The daemon's state store: a write queue in front of the state files, which reports what cannot
/// be written.
#pragma once

#include <condition_variable>
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

/// `config.directory`, or the first folder of $STATE_DIRECTORY; none: neither is set.
std::optional<std::string> state_directory_of(const StateConfig& config);

/// Write-behind queue of state items, which the disk thread writes. An item whose write fails stays
/// queued and is retried every two seconds. Only the newest item of a kind and name is queued.
/// Thread-safe. Without a store the daemon works all the same, and keeps nothing.
class DaemonStore {
 public:
  /// The result of a write: the item's checksum, or why it is not stored (yet). Called in the disk
  /// thread after the first attempt, and again if a later one succeeds; in the caller's thread if
  /// there is no attempt.
  using Tried = std::function<void(const Result<std::string>& kept)>;
  using Dropped = std::function<void(const Result<void>& dropped)>;
  /// What happens to the item of the same name on the disk while the new one cannot be written.
  enum class Older {
    stays,
    set_aside,  ///< renamed: it is outdated, and a restart must not load it
  };
  /// Limit of the memory of queued items; an item beyond it is not stored.
  static constexpr std::size_t kMaxQueuedBytes = std::size_t{128} << 20;

  /// Opens the store in state_directory_of(config); blocks on the disk. Emits an event if no folder
  /// is configured, or if it is unusable or read-only. Items in a read-only folder are loaded.
  /// Without `disk`, the calling thread carries out every operation at once.
  DaemonStore(const StateConfig& config, Events& events, Disk* disk = nullptr);

  // Any thread; these never block on the disk.
  /// Queues the write of an item. Errors: Errc::unavailable (no store, too much queued), or as of
  /// replace_file; Errc::refused: a newer item replaced it in the queue.
  void put(std::string_view kind, std::string_view name, const nlohmann::json& content, Older older,
           Tried tried);
  /// Deletes an item, queued or on the disk, in one attempt. Errors: see remove_file; without a
  /// store there is nothing to delete.
  void drop(std::string_view kind, std::string_view name, Dropped dropped);
  /// Deletes several items; `dropped` is called once, with the first error.
  void drop_all(std::string_view kind, const std::vector<std::string>& names, Dropped dropped);
  /// The callback for `put` that reports the result as an event of kind `kind` about `title`, then
  /// calls `then` with the checksum; empty: the item is not stored.
  Tried reporting(std::string kind, std::string title, std::int64_t t_taken_ns,
                  std::function<void(const std::string& sha256)> then);
  /// Why the write of an item of this kind failed; none: no failed one is queued.
  std::optional<std::string> why_queued(std::string_view kind) const;
  bool is_queued(std::string_view kind, std::string_view name) const;
  StatusMessage::StorePart report() const;
  /// Runs `task` in the disk thread, after what was queued there before. Errors: see Disk::request.
  Result<void> request(Disk::Task task);

  // Threads that may block on the disk; an older item stays.
  Result<std::string> put_and_wait(std::string_view kind, std::string_view name,
                                   const nlohmann::json& content);
  Result<void> drop_and_wait(std::string_view kind, std::string_view name);
  /// Returns when everything queued has been tried once more.
  void try_again_and_wait();
  /// The queued item, or else the one on the disk.
  std::optional<StateItem> find(std::string_view kind, std::string_view name) const;
  /// The same for all items of a kind; see StateStore::load. An event reports each damaged file,
  /// which is not used.
  void load(std::string_view kind, const std::function<void(StateItem)>& take) const;

  /// Disk thread, each turn: tries one item. True if another one is due.
  bool turn();
  /// The daemon stops: calls that wait return with Errc::unavailable from now on.
  void end_soon();
  /// Number of items that are not on the disk yet.
  int queued() const;

 private:
  struct Item {
    std::string kind, name;
    std::shared_ptr<const std::string> text;  ///< null: delete the item, or set it aside
    Older older = Older::stays;
    Tried tried;
    std::uint64_t number = 0;          ///< in the order of the requests
    bool due = true;                   ///< try it in the next turn
    std::optional<std::string> why{};  ///< why the last attempt failed
    /// The write that this item took out of the queue; it waits again if nothing can be deleted.
    std::shared_ptr<const Item> displaced{};
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
  template <class T>
  Result<T> wait_for(const std::function<void(std::function<void(const Result<T>&)>)>& ask);

  Events& events_;
  Disk* disk_;
  std::optional<StateStore> store_;  ///< not changed after the constructor
  std::optional<std::string> directory_, why_none_;

  mutable std::mutex mutex_;  ///< never held while the disk works
  std::condition_variable tried_;
  std::list<Item> items_;                ///< oldest first
  std::optional<std::uint64_t> trying_;  ///< its number
  std::uint64_t last_number_ = 0;
  std::int64_t next_try_ns_ = 0;
  int refused_ = 0;                           ///< items whose write failed since all was written
  std::optional<std::string> why_read_only_;  ///< until a write succeeds
  bool ending_ = false;
};

}  // namespace ovws
