#include "daemon/daemon_store.hpp"

#include <cstdlib>

namespace ovws {
namespace {

std::string item_of(std::string_view kind, std::string_view name) {
  return std::string(kind) + '/' + std::string(name);
}

}  // namespace

std::optional<std::string> state_directory_of(const StateConfig& config) {
  if (config.directory) return config.directory;
  const char* const list = std::getenv("STATE_DIRECTORY");
  if (list == nullptr || *list == '\0') return std::nullopt;
  const std::string_view all = list;  // systemd separates several by colons
  return std::string(all.substr(0, all.find(':')));
}

DaemonStore::DaemonStore(const StateConfig& config, Events& events) : events_(events) {
  const auto directory = state_directory_of(config);
  if (!directory) {
    why_none_ = "no folder is named: set state.directory, or $STATE_DIRECTORY";
    report_.set({std::nullopt, why_none_});
    events_.emit("store", Severity::info, "nothing is kept over a restart: " + *why_none_);
    return;
  }
  auto opened = StateStore::open(*directory);
  if (!opened) {
    why_none_ = opened.error().reason;
    report_.set({std::nullopt, why_none_});
    events_.emit("store", Severity::error, "nothing is kept over a restart: " + *why_none_,
                 {{"path", *directory}});
    return;
  }
  why_read_only_ = opened->why_read_only();
  report_.set({directory, why_read_only_});
  if (why_read_only_) {
    events_.emit(
        "store", Severity::error,
        "nothing new is kept over a restart, what is kept already is used: " + *why_read_only_,
        {{"path", *directory}});
  }
  if (opened->leftovers() > 0) {
    events_.emit("store", Severity::info,
                 "files that were being written when the daemon was killed are removed: " +
                     std::to_string(opened->leftovers()),
                 {{"path", *directory}, {"removed", opened->leftovers()}});
  }
  store_ = std::move(*opened);
}

/// What could not be kept is told until that very item is kept or dropped.
void DaemonStore::note(const std::string& item, const std::optional<std::string>& why_not_kept) {
  if (why_not_kept) {
    not_kept_[item] = *why_not_kept;
  } else {
    not_kept_.erase(item);
  }
  tell();
}

void DaemonStore::tell() {
  StatusMessage::StorePart report = report_.get();
  report.reason = store_ ? why_read_only_ : why_none_;
  if (!not_kept_.empty()) report.reason = not_kept_.begin()->second;
  report_.set(report);
}

Result<std::string> DaemonStore::put(std::string_view kind, std::string_view name,
                                     const nlohmann::json& content) {
  const std::lock_guard lock(mutex_);
  if (!store_) return fail(Errc::unavailable, "state.directory", *why_none_);
  auto kept = store_->put(kind, name, content);
  if (kept) why_read_only_.reset();
  note(item_of(kind, name), kept ? std::nullopt : std::optional(kept.error().reason));
  return kept;
}

Result<void> DaemonStore::drop(std::string_view kind, std::string_view name) {
  const std::lock_guard lock(mutex_);
  if (!store_) return {};
  auto dropped = store_->drop(kind, name);
  if (dropped) note(item_of(kind, name), std::nullopt);
  return dropped;
}

void DaemonStore::give_up(std::string_view kind, std::string_view name) {
  const std::lock_guard lock(mutex_);
  const std::string item = item_of(kind, name);
  std::erase_if(not_kept_, [&](const auto& one) {
    return name.empty() ? one.first.starts_with(item) : one.first == item;
  });
  tell();
}

std::optional<StateItem> DaemonStore::find(std::string_view kind, std::string_view name) const {
  const std::lock_guard lock(mutex_);
  if (!store_) return std::nullopt;
  return store_->find(kind, name);
}

void DaemonStore::load(std::string_view kind, const std::function<void(StateItem)>& take) const {
  const std::lock_guard lock(mutex_);
  if (!store_) return;
  for (const BadState& bad : store_->load(kind, take)) {
    events_.emit("store", Severity::warning,
                 bad.path + " is not used, and left as it is: " + bad.reason,
                 {{"path", bad.path}, {"reason", bad.reason}});
  }
}

}  // namespace ovws
