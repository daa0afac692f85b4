#include "daemon/ovwsd/store/daemon_store.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cstdlib>
#include <exception>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr std::int64_t kRetryNs = 2'000'000'000;

}  // namespace

std::optional<std::string> state_directory_of(const StateConfig& config) {
  if (config.directory) return config.directory;
  const char* const list = std::getenv("STATE_DIRECTORY");
  if (list == nullptr || *list == '\0') return std::nullopt;
  const std::string_view all = list;  // systemd separates folders by colons
  return std::string(all.substr(0, all.find(':')));
}

DaemonStore::DaemonStore(const StateConfig& config, Events& events, Disk* disk)
    : events_(events), disk_(disk) {
  const auto directory = state_directory_of(config);
  if (!directory) {
    why_none_ = "no state folder is configured: set state.directory or $STATE_DIRECTORY";
    events_.emit("store", Severity::info, "nothing is saved across restarts: " + *why_none_);
    return;
  }
  auto opened = StateStore::open(*directory);
  if (!opened) {
    why_none_ = opened.error().reason;
    events_.emit("store", Severity::error, "nothing is saved across restarts: " + *why_none_,
                 {{"path", *directory}});
    return;
  }
  directory_ = directory;
  why_read_only_ = opened->why_read_only();
  if (why_read_only_) {
    events_.emit(
        "store", Severity::error,
        "new measurements and settings are lost at a restart; those saved before are used: " +
            *why_read_only_,
        {{"path", *directory}});
  }
  if (opened->leftovers() > 0) {
    events_.emit("store", Severity::info,
                 "incomplete files that a killed daemon left behind were removed: " +
                     std::to_string(opened->leftovers()),
                 {{"path", *directory}, {"removed", opened->leftovers()}});
  }
  store_ = std::move(*opened);
}

void DaemonStore::put(std::string_view kind, std::string_view name, const json& content,
                      Older older, Tried tried) {
  if (!store_) return tried(fail(Errc::unavailable, "state.directory", *why_none_));
  Item item{std::string(kind), std::string(name), nullptr, older, std::move(tried)};
  item.text = std::make_shared<const std::string>(StateStore::text_of(kind, content));
  queue(std::move(item));
}

void DaemonStore::drop(std::string_view kind, std::string_view name, Dropped dropped) {
  if (!store_) return dropped({});
  const auto tried = [dropped = std::move(dropped)](const Result<std::string>& done) {
    dropped(done ? Result<void>{} : fail(done.error()));
  };
  queue({std::string(kind), std::string(name), nullptr, Older::stays, tried});
}

void DaemonStore::drop_all(std::string_view kind, const std::vector<std::string>& names,
                           Dropped dropped) {
  struct Outcome {
    std::mutex mutex;
    std::size_t missing;
    Result<void> all;
  };
  if (names.empty()) return dropped({});
  const auto outcome = std::make_shared<Outcome>();
  outcome->missing = names.size();
  for (const std::string& name : names) {
    drop(kind, name, [outcome, dropped](const Result<void>& one) {
      Result<void> all;
      {
        const std::lock_guard lock(outcome->mutex);
        if (!one && outcome->all) outcome->all = one;
        if (--outcome->missing > 0) return;
        all = outcome->all;
      }
      dropped(all);
    });
  }
}

/// Memory that the item uses, about.
std::size_t DaemonStore::Item::bytes() const {
  constexpr std::size_t kOwnBytes = 1024;
  return kOwnBytes + (text ? text->size() : 0) + (displaced ? displaced->bytes() : 0);
}

/// Pending write of the kind and name of `newer`: queued, in progress, or displaced by a pending
/// deletion. Null: no write is pending.
std::shared_ptr<const DaemonStore::Item> DaemonStore::write_before(const Item& newer) const {
  const auto last = std::find_if(items_.rbegin(), items_.rend(), [&](const Item& one) {
    return one.kind == newer.kind && one.name == newer.name;
  });
  if (last == items_.rend()) return nullptr;
  return last->text ? std::make_shared<const Item>(*last) : last->displaced;
}

/// Removes queued items with the kind and name of `newer`, and returns them. An item that is being
/// written is removed but not returned, because turn() reports its result.
std::list<DaemonStore::Item> DaemonStore::take_out(const Item& newer) {
  std::list<Item> taken;
  for (auto at = items_.begin(); at != items_.end();) {
    const auto one = at++;
    if (one->kind != newer.kind || one->name != newer.name) continue;
    if (trying_ == one->number) {
      items_.erase(one);
    } else {
      taken.splice(taken.end(), items_, one);
    }
  }
  return taken;
}

/// Queues an item in place of older items with its kind and name. An item beyond the memory limit
/// is refused; with Older::set_aside the outdated file is then still set aside.
void DaemonStore::queue(Item item) {
  std::list<Item> displaced;
  Tried refused;
  {
    const std::lock_guard lock(mutex_);
    if (!item.text && item.older == Older::stays) item.displaced = write_before(item);
    std::size_t bytes = item.bytes();
    for (const Item& one : items_) {
      const bool same = one.kind == item.kind && one.name == item.name;
      bytes += same ? 0 : one.bytes();
    }
    if (bytes > kMaxQueuedBytes) {
      refused = std::exchange(item.tried, [](const Result<std::string>&) {});
      item.text = nullptr;
    }
    if (!refused || item.older == Older::set_aside) {
      displaced = take_out(item);
      item.number = ++last_number_;
      items_.push_back(std::move(item));
    }
  }
  for (const Item& one : displaced) {
    if (one.why) continue;  // the failure of this item was reported before
    one.tried(fail(Errc::refused, "", "a newer item replaced it before it was written"));
  }
  if (refused) {
    refused(fail(
        Errc::unavailable, "state.directory",
        fmt::format("{} MiB already wait to be written: check the disk", kMaxQueuedBytes >> 20)));
  }
  wake();
}

void DaemonStore::wake() {
  if (disk_ != nullptr) return disk_->post([this] { (void)turn(); });
  while (turn()) {
  }
}

bool DaemonStore::turn() {
  Item item;
  {
    const std::lock_guard lock(mutex_);
    if (refused_ > 0 && monotonic_ns() >= next_try_ns_) make_all_due();
    const auto next =
        std::find_if(items_.begin(), items_.end(), [](const Item& one) { return one.due; });
    if (next == items_.end() || trying_) return false;
    item = *next;
    next->due = false;
    trying_ = next->number;
  }
  const Result<std::string> done = carry_out(item);
  bool all_written = false, more = false;
  {
    const std::lock_guard lock(mutex_);
    settle(item, done);
    trying_.reset();
    all_written = refused_ > 0 && items_.empty();
    if (all_written) refused_ = 0;
    more = any_due();
  }
  if (done || !item.why) item.tried(done);
  if (all_written) {
    events_.emit("store", Severity::info, "all waiting items have been written",
                 {{"path", *directory_}});
  }
  return more;
}

/// Turns an exception into an error, so that the item is retried.
Result<std::string> DaemonStore::carry_out(const Item& item) {
  try {
    return write(item);
  } catch (const std::exception& error) {
    return fail(Errc::internal, "", error.what());
  }
}

Result<std::string> DaemonStore::write(const Item& item) {
  if (!item.text) {
    const bool aside = item.older == Older::set_aside;
    auto gone =
        aside ? store_->set_aside(item.kind, item.name) : store_->drop(item.kind, item.name);
    if (!gone) return fail(gone.error());
    return std::string();
  }
  auto kept = store_->put_text(item.kind, item.name, *item.text);
  if (!kept && store_->recreate_directory()) {
    events_.emit("store", Severity::warning,
                 *directory_ + " was removed, with everything saved in it; it was created again",
                 {{"path", *directory_}});
    kept = store_->put_text(item.kind, item.name, *item.text);
  }
  if (kept || item.older == Older::stays) return kept;
  if (!store_->set_aside(item.kind, item.name)) {
    kept.error().reason += "; until it is written, a restart loads the previous one";
  }
  return kept;
}

/// Removes a finished item from the queue, or marks it for a retry. A deletion is tried once. If
/// the deletion fails, its caller undoes the change, and the displaced write is queued again.
void DaemonStore::settle(const Item& item, const Result<std::string>& done) {
  const auto now = std::find_if(items_.begin(), items_.end(),
                                [&](const Item& one) { return one.number == item.number; });
  if (done && item.text) why_read_only_.reset();
  if (done && item.why) make_all_due();  // the disk has room again
  if (!done) next_try_ns_ = monotonic_ns() + kRetryNs;
  if (now == items_.end()) return;  // a newer item has replaced this one
  if (!done && item.text) {
    if (!now->why) ++refused_;
    now->why = done.error().reason;
    return;
  }
  const auto displaced = done ? nullptr : now->displaced;
  items_.erase(now);
  if (!displaced) return;
  items_.push_back(*displaced);
  Item& again = items_.back();
  again.due = false;
  if (!again.why) ++refused_;
  again.why = done.error().reason;
}

bool DaemonStore::any_due() const {
  return std::any_of(items_.begin(), items_.end(), [](const Item& one) { return one.due; });
}

void DaemonStore::make_all_due() {
  for (Item& one : items_) one.due = one.due || one.number != trying_;
  next_try_ns_ = monotonic_ns() + kRetryNs;
}

DaemonStore::Tried DaemonStore::reporting(std::string kind, std::string title,
                                          std::int64_t t_taken_ns,
                                          std::function<void(const std::string&)> then) {
  return [this, kind = std::move(kind), title = std::move(title), t_taken_ns,
          then = std::move(then)](const Result<std::string>& kept) {
    json data{{"t_taken_ns", t_taken_ns}};
    if (kept) {
      data["sha256"] = *kept;
      events_.emit(kind, Severity::info, fmt::format("{} is saved (sha256 {})", title, *kept),
                   data);
    } else if (directory_) {
      events_.emit(kind, Severity::error,
                   fmt::format("{} is active, but will not survive a restart: {}", title,
                               kept.error().reason),
                   data);
    }
    if (then) then(kept.value_or(""));
  };
}

StatusMessage::StorePart DaemonStore::report() const {
  const std::lock_guard lock(mutex_);
  StatusMessage::StorePart report{directory_, store_ ? why_read_only_ : why_none_};
  const auto refused = [](const Item& one) { return one.why.has_value(); };
  const auto last = std::find_if(items_.rbegin(), items_.rend(), refused);
  if (last == items_.rend()) return report;
  report.reason = fmt::format("{}; items waiting to be written again: {}", *last->why,
                              std::count_if(items_.begin(), items_.end(), refused));
  return report;
}

int DaemonStore::queued() const {
  const std::lock_guard lock(mutex_);
  return int(items_.size());
}

Result<void> DaemonStore::request(Disk::Task task) {
  if (disk_ != nullptr) return disk_->request(std::move(task));
  task();
  return {};
}

std::vector<DaemonStore::Item> DaemonStore::queued_of(std::string_view kind) const {
  std::vector<Item> found;
  const std::lock_guard lock(mutex_);
  for (const Item& item : items_) {
    if (item.kind == kind) found.push_back(item);
  }
  return found;
}

std::optional<StateItem> DaemonStore::find(std::string_view kind, std::string_view name) const {
  if (!store_) return std::nullopt;
  for (const Item& item : queued_of(kind)) {
    if (item.name != name) continue;
    return item.text ? std::optional(store_->item_of(kind, name, *item.text)) : std::nullopt;
  }
  return store_->find(kind, name);
}

void DaemonStore::load(std::string_view kind, const std::function<void(StateItem)>& take) const {
  if (!store_) return;
  const std::vector<Item> queued = queued_of(kind);
  const auto from_disk = [&](StateItem item) {
    const bool newer = std::any_of(queued.begin(), queued.end(),
                                   [&](const Item& one) { return one.name == item.name; });
    if (!newer) take(std::move(item));
  };
  for (const BadState& bad : store_->load(kind, from_disk)) {
    events_.emit("store", Severity::warning,
                 bad.path + " is not used, and left as it is: " + bad.reason +
                     "; restore it from a backup, or delete it",
                 {{"path", bad.path}, {"reason", bad.reason}});
  }
  for (const Item& item : queued) {
    if (item.text) take(store_->item_of(kind, item.name, *item.text));
  }
}

}  // namespace ovws
