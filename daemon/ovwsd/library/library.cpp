#include "daemon/ovwsd/library/library.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <tuple>

#include "core/port/clock.hpp"
#include "daemon/shared/service_notify.hpp"
#include "proto/tables/files.hpp"
#include "proto/tables/time.hpp"

namespace ovws {
namespace {

using nlohmann::json;

constexpr std::int64_t kRetryNs = 2'000'000'000;
constexpr double kLoadPatienceS = 60.0;  // to load one file

}  // namespace

std::string title_of(const ItemKind& kind, std::int64_t t_taken_ns) {
  return fmt::format("the {} of {}", kind.title, utc_text(t_taken_ns));
}

Library::Library(const StateConfig& config, Events& events, Disk* disk)
    : events_(events), disk_(disk) {
  const auto directory = state_directory_of(config);
  if (!directory) {
    why_none_ = "no state folder is configured: set state.directory or $STATE_DIRECTORY";
    events_.emit("store", Severity::info, "nothing is saved across restarts: " + *why_none_);
    return;
  }
  auto opened = StateFolder::open(*directory);
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
  folder_ = std::move(*opened);
}

/// Memory that the work uses, about.
std::size_t Library::Work::bytes() const {
  constexpr std::size_t kOwnBytes = 1024;
  return kOwnBytes + (text ? text->size() : 0);
}

/// Queues work in place of older work on the same item. A removal that a write replaces succeeds:
/// the write overwrites what was to be removed.
void Library::add(const Key& key, Work work) {
  work.number = ++last_number_;
  Work& slot = queue_[key];
  if (slot.done) displace(std::move(slot.done), slot.removes && !work.removes);
  slot = std::move(work);
}

void Library::displace(Stored done, bool succeeds) {
  displaced_.emplace_back(
      std::move(done),
      succeeds ? Result<std::string>()
               : fail(Errc::refused, "", "a newer request replaced it before it was carried out"));
}

void Library::forget_file(const Key& key) {
  std::erase_if(files_[key.first], [&](const auto& one) { return one.second == key.second; });
}

/// Counts the file as the newest one of its kind. Returns the names of the oldest ones if there are
/// more than `most` (0: no limit), and counts them no more.
std::vector<std::string> Library::count_file(const Key& key, std::int64_t t_taken_ns,
                                             std::size_t most) {
  forget_file(key);
  Files& files = files_[key.first];
  files.emplace_back(t_taken_ns, key.second);
  std::vector<std::string> too_many;
  while (most > 0 && files.size() > most) {
    // The newest file stays even if the clock was set back.
    const auto oldest = std::min_element(files.begin(), std::prev(files.end()));
    too_many.push_back(oldest->second);
    files.erase(oldest);
  }
  return too_many;
}

/// An item beyond the memory limit is refused; the outdated file is then still set aside.
void Library::put(Item item, Stored stored) {
  if (!folder_) {
    if (stored) stored(fail(Errc::unavailable, "state.directory", *why_none_));
    return;
  }
  const ItemKind& kind = *item.kind;
  const Key key{kind.name, item.name};
  Work work{nullptr, std::make_shared<const std::string>(
                         StateFolder::text_of(kind.name, std::exchange(item.content, nullptr)))};
  work.done = std::move(stored);
  work.item = std::make_shared<const Item>(std::move(item));
  Work refused;
  std::vector<std::string> too_many;
  {
    const std::lock_guard lock(mutex_);
    std::size_t bytes = work.bytes();
    for (const auto& [other, one] : queue_) bytes += other == key ? 0 : one.bytes();
    if (bytes > kMaxQueuedBytes) {
      std::swap(refused, work);
      forget_file(key);  // it is set aside
    } else {
      too_many = count_file(key, work.item->t_taken_ns, kind.most);
    }
    sums_.erase(key);
    add(key, std::move(work));
  }
  if (refused.item) {
    const Result<std::string> why = fail(
        Errc::unavailable, "state.directory",
        fmt::format("{} MiB already wait to be written: check the disk", kMaxQueuedBytes >> 20));
    publish(refused, why);
    if (refused.done) refused.done(why);
  }
  wake();
  remove_quietly(kind, too_many);
}

void Library::remove(const ItemKind& kind, const std::vector<std::string>& names,
                     const Removed& removed) {
  if (!folder_ || names.empty()) return removed({});
  {
    struct All {
      std::size_t left;
      Result<void> result{};
    };
    const auto all = std::make_shared<All>(names.size());
    const std::lock_guard lock(mutex_);
    for (const std::string& name : names) {
      const Key key{kind.name, name};
      forget_file(key);
      const auto waiting = queue_.find(key);
      Work work = waiting == queue_.end() ? Work{} : waiting->second;
      if (work.done) displace(std::exchange(work.done, nullptr), false);
      work.removes = work.due = true;
      work.why.reset();
      work.done = [all, removed](const Result<std::string>& one) {
        if (!one && all->result) all->result = fail(one.error());
        if (--all->left == 0) removed(all->result);
      };
      if (waiting != queue_.end()) waiting->second.done = nullptr;
      add(key, std::move(work));
    }
  }
  wake();
}

void Library::remove_quietly(const ItemKind& kind, const std::vector<std::string>& names) {
  remove(kind, names, [this, event = kind.event](const Result<void>& removed) {
    if (!removed) events_.emit(event, Severity::warning, removed.error().reason);
  });
}

void Library::wake() {
  if (disk_ != nullptr) return disk_->post([this] { (void)turn(); });
  while (turn()) {
  }
}

bool Library::turn() {
  Key key;
  Work work;
  decltype(displaced_) displaced;
  {
    const std::lock_guard lock(mutex_);
    displaced.swap(displaced_);
    if (waiting_ && monotonic_ns() >= next_try_ns_) make_all_due();
    auto next = queue_.end();
    for (auto at = queue_.begin(); at != queue_.end(); ++at) {
      const bool older = next == queue_.end() || at->second.number < next->second.number;
      if (at->second.due && older) next = at;
    }
    if (next != queue_.end()) {
      next->second.due = false;
      std::tie(key, work) = *next;
      next->second.done = nullptr;
    }
  }
  for (const auto& [done, result] : displaced) done(result);
  if (work.number == 0) return false;
  const Result<std::string> done = carry_out(key, work);
  bool all_written = false, more = false;
  {
    const std::lock_guard lock(mutex_);
    settle(key, work, done);
    all_written = waiting_ && queue_.empty();
    if (all_written) waiting_ = false;
    more = any_due();
  }
  if (!work.removes && (done || !work.why)) publish(work, done);
  if (work.done) work.done(done);
  if (all_written) {
    events_.emit("store", Severity::info, "no item waits to be written any more",
                 {{"path", *directory_}});
  }
  return more;
}

/// Turns an exception into an error, so that the item is retried.
Result<std::string> Library::carry_out(const Key& key, const Work& work) {
  try {
    return write(key, work);
  } catch (const std::exception& error) {
    return fail(Errc::internal, "", error.what());
  }
}

Result<std::string> Library::write(const Key& key, const Work& work) {
  const auto& [kind, name] = key;
  if (work.removes || !work.text) {
    auto gone = work.removes ? folder_->remove(kind, name) : folder_->set_aside(kind, name);
    if (!gone) return fail(gone.error());
    return std::string();
  }
  auto written = folder_->write(kind, name, *work.text);
  if (!written && folder_->recreate()) {
    events_.emit("store", Severity::warning,
                 *directory_ + " was removed, with everything saved in it; it was created again",
                 {{"path", *directory_}});
    written = folder_->write(kind, name, *work.text);
  }
  if (!written && !folder_->set_aside(kind, name)) {
    written.error().reason += "; until it is written, a restart loads the previous one";
  }
  return written;
}

/// Removes finished work from the queue, or marks it for a retry. A removal is tried once.
void Library::settle(const Key& key, const Work& work, const Result<std::string>& done) {
  const bool written = done && work.text && !work.removes;
  if (written) why_read_only_.reset();
  if (done && work.why) make_all_due();  // the disk has room again
  if (!done) next_try_ns_ = monotonic_ns() + kRetryNs;
  const auto now = queue_.find(key);
  if (now == queue_.end() || now->second.number != work.number) return;  // replaced meanwhile
  if (written) sums_[key] = *done;
  if (done && !written) sums_.erase(key);
  const bool given_up = !done && work.item && work.item->once;
  if (given_up) forget_file(key);
  if (done || !work.text || given_up) {
    queue_.erase(now);
    return;
  }
  now->second.removes = false;
  now->second.why = done.error().reason;
  waiting_ = true;
}

/// Reports the result of a write, and removes what the item replaces.
void Library::publish(const Work& work, const Result<std::string>& done) {
  if (!work.item) return;
  const Item& item = *work.item;
  if (done) remove_quietly(*item.kind, item.replaces);
  if (item.title.empty()) return;
  json data{{"t_taken_ns", item.t_taken_ns}};
  if (done) {
    data["sha256"] = *done;
    events_.emit(item.kind->event, Severity::info,
                 fmt::format("{} is saved (sha256 {})", item.title, *done), data);
  } else {
    events_.emit(item.kind->event, Severity::error,
                 fmt::format("{} is active, but will not survive a restart: {}", item.title,
                             done.error().reason),
                 data);
  }
}

bool Library::any_due() const {
  return std::ranges::any_of(queue_, [](const auto& one) { return one.second.due; });
}

void Library::make_all_due() {
  for (auto& [key, work] : queue_) work.due = true;
  next_try_ns_ = monotonic_ns() + kRetryNs;
}

std::string Library::sha256(const ItemKind& kind, const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = sums_.find({kind.name, name});
  return found == sums_.end() ? "" : found->second;
}

StatusMessage::StorePart Library::report() const {
  const std::lock_guard lock(mutex_);
  StatusMessage::StorePart report{directory_, folder_ ? why_read_only_ : why_none_};
  const Work* last = nullptr;
  int refused = 0;
  for (const auto& [key, work] : queue_) {
    if (!work.why) continue;
    ++refused;
    if (last == nullptr || work.number > last->number) last = &work;
  }
  if (last == nullptr) return report;
  report.reason = fmt::format("{}; items waiting to be written again: {}", *last->why, refused);
  return report;
}

int Library::queued() const {
  const std::lock_guard lock(mutex_);
  return int(queue_.size());
}

Result<void> Library::request(Disk::Task task) {
  if (disk_ != nullptr) return disk_->request(std::move(task));
  task();
  return {};
}

Result<StateItem> Library::read(const ItemKind& kind, const std::string& name) const {
  if (!folder_) return fail(Errc::unavailable, "state.directory", *why_none_);
  return folder_->read(kind.name, name);
}

Result<void> Library::check_new(const ItemKind& kind, const std::string& name) const {
  if (!folder_ || !folder_->holds(kind.name, name)) return {};
  return fail(Errc::refused, "name",
              fmt::format("{} exists and was not loaded: choose another name, restore the file "
                          "from a backup, or delete it; then restart the daemon",
                          folder_->path_of(kind.name, name)));
}

void Library::load(const ItemKind& kind,
                   const std::function<Result<void>(const StateItem&)>& take) {
  if (!folder_) return;
  for (const std::string& name : folder_->names(kind.name)) {
    service::notify_extend(kLoadPatienceS);  // a large file takes seconds
    const auto wrong = no_reference_name(name);
    const auto item =
        wrong ? fail(Errc::invalid, "its name", *wrong) : folder_->read(kind.name, name);
    if (item) {
      const std::lock_guard lock(mutex_);
      sums_[{kind.name, name}] = item->sha256;
    }
    const Result<void> taken = item ? take(*item) : fail(item.error());
    std::unique_lock lock(mutex_);
    if (taken) {
      const auto t_taken_ns = item->content.find("t_taken_ns");
      const bool timed = t_taken_ns != item->content.end() && t_taken_ns->is_number_integer();
      (void)count_file({kind.name, name}, timed ? t_taken_ns->get<std::int64_t>() : 0, 0);
      continue;
    }
    sums_.erase({kind.name, name});
    lock.unlock();
    const std::string path = folder_->path_of(kind.name, name);
    const Error& why = taken.error();
    events_.emit(
        item ? kind.event : "store", Severity::warning,
        fmt::format("{} is not used, and left as it is: {}{}{}; restore it from a "
                    "backup, or delete it and run {}",
                    path, why.field, why.field.empty() ? "" : " ", why.reason, kind.method),
        {{"path", path}, {"used", false}});
  }
}

void Library::publish_loaded(const ItemKind& kind, const std::string& name, std::int64_t t_taken_ns,
                             const std::string& obstacle) {
  const std::string path = folder_->path_of(kind.name, name), sum = sha256(kind, name);
  const std::string what =
      obstacle.empty()
          ? "is loaded"
          : fmt::format("is not used: {}; undo what has changed, or run {}", obstacle, kind.method);
  events_.emit(
      kind.event, obstacle.empty() ? Severity::info : Severity::warning,
      fmt::format("{} ({}, sha256 {}) {}", title_of(kind, t_taken_ns), path, sum, what),
      {{"path", path}, {"sha256", sum}, {"used", obstacle.empty()}, {"t_taken_ns", t_taken_ns}});
}

}  // namespace ovws
