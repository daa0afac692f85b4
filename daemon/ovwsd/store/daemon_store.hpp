/// The daemon's store: where it is, or why there is none, and what could not be kept yet.
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
#include "proto/tables/status.hpp"

namespace ovws {

/// `config.directory`, or the first of $STATE_DIRECTORY; none: neither is set.
std::optional<std::string> state_directory_of(const StateConfig& config);

/// A queue of items to write, which the disk thread works off. An item that the disk refuses stays
/// in the queue and is tried again every two seconds; of each kind and name only the newest is
/// queued. Thread-safe. Without a store the daemon runs all the same.
class DaemonStore {
 public:
  /// What became of an item: its checksum, or why it is not kept (yet). Called in the disk thread
  /// after the first try, and again if a later one succeeds; in the caller's if nothing is tried.
  using Tried = std::function<void(const Result<std::string>& kept)>;
  using Dropped = std::function<void(const Result<void>& dropped)>;
  /// What happens to the older item of that name on the disk while the new one cannot be written.
  enum class Older {
    stays,
    set_aside,  ///< it is outdated: a restart must not load it
  };
  /// Queued items hold at most so much memory; what comes beyond is not kept.
  static constexpr std::size_t kMaxQueuedBytes = std::size_t{128} << 20;

  /// In state_directory_of; waits for the disk. A store that cannot be used or written, or none, is
  /// reported here, once; what is in one that can only be read is read. Without `disk` everything
  /// is done at once, in the calling thread.
  DaemonStore(const StateConfig& config, Events& events, Disk* disk = nullptr);

  // Any thread; these never wait for the disk.
  /// Errors: Errc::unavailable (there is no store, too much is queued, or as of replace_file).
  void put(std::string_view kind, std::string_view name, const nlohmann::json& content, Older older,
           Tried tried);
  /// Tried once, also an item that is still queued. Errors as of remove_file; without a store there
  /// is nothing to drop.
  void drop(std::string_view kind, std::string_view name, Dropped dropped);
  /// The same of several: `dropped` once, with the first error.
  void drop_all(std::string_view kind, const std::vector<std::string>& names, Dropped dropped);
  /// The events of kind `kind` about `title`, which belong to every put; then `then` with the
  /// checksum, empty if it is not kept.
  Tried reporting(std::string kind, std::string title, std::int64_t t_taken_ns,
                  std::function<void(const std::string& sha256)> then);
  /// Why an item of this kind is still queued; none: none was refused.
  std::optional<std::string> why_queued(std::string_view kind) const;
  bool is_queued(std::string_view kind, std::string_view name) const;
  StatusMessage::StorePart report() const;
  /// `task` is carried out in the disk thread, after what was asked for before.
  Result<void> request(Disk::Task task);

  // Threads that may wait for the disk; an older item stays.
  Result<std::string> put_and_wait(std::string_view kind, std::string_view name,
                                   const nlohmann::json& content);
  Result<void> drop_and_wait(std::string_view kind, std::string_view name);
  /// Until everything that is queued was tried once more.
  void try_again_and_wait();
  /// The queued item, or else that on the disk.
  std::optional<StateItem> find(std::string_view kind, std::string_view name) const;
  /// The same of all of a kind, as of StateStore::load; of every file that is not whole an event
  /// says why it is not used.
  void load(std::string_view kind, const std::function<void(StateItem)>& take) const;

  /// Disk thread, each turn: tries one item. Returns whether another one is due.
  bool turn();
  /// Nobody waits from now on: the daemon stops.
  void end_soon();
  /// Items that are not on the disk.
  int queued() const;

 private:
  struct Item {
    std::string kind, name;
    std::shared_ptr<const std::string> text;  ///< null: to be dropped, or set aside
    Older older = Older::stays;
    Tried tried;
    std::uint64_t number = 0;          ///< of the order in which they were asked for
    bool due = true;                   ///< to be tried in the next turn
    std::optional<std::string> why{};  ///< it was refused for
  };
  void queue(Item item);
  std::list<Item> take_out(const Item& newer);  // call with mutex_ locked
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
  int refused_ = 0;                           ///< items since all was written
  std::optional<std::string> why_read_only_;  ///< at the start, and until something is kept
  bool ending_ = false;
};

}  // namespace ovws
