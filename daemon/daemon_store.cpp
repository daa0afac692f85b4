#include "daemon/daemon_store.hpp"

#include <cstdlib>

namespace ovws {
namespace {

std::optional<std::string> directory_of(const StateConfig& config) {
  if (config.directory) return config.directory;
  const char* const list = std::getenv("STATE_DIRECTORY");
  if (list == nullptr || *list == '\0') return std::nullopt;
  const std::string_view all = list;  // systemd separates several by colons
  return std::string(all.substr(0, all.find(':')));
}

}  // namespace

DaemonStore::DaemonStore(const StateConfig& config, Events& events) : events_(events) {
  const auto directory = directory_of(config);
  if (!directory) {
    report_.reason = "no folder is named: set state.directory, or $STATE_DIRECTORY";
    events_.emit("store", Severity::info, "nothing is kept over a restart: " + *report_.reason);
    return;
  }
  auto opened = StateStore::open(*directory);
  if (!opened) {
    report_.reason = opened.error().reason;
    events_.emit("store", Severity::error, "nothing is kept over a restart: " + *report_.reason,
                 {{"path", *directory}});
    return;
  }
  report_.directory = directory;
  if (opened->leftovers() > 0) {
    events_.emit("store", Severity::info,
                 "files that were being written when the daemon was killed are removed: " +
                     std::to_string(opened->leftovers()),
                 {{"path", *directory}, {"removed", opened->leftovers()}});
  }
  store_ = std::move(*opened);
}

Result<std::string> DaemonStore::put(std::string_view kind, std::string_view name,
                                     const nlohmann::json& content) {
  const std::lock_guard lock(mutex_);
  if (!store_) return fail(Errc::unavailable, "state.directory", *report_.reason);
  auto kept = store_->put(kind, name, content);
  report_.reason.reset();
  if (!kept) report_.reason = kept.error().reason;
  return kept;
}

Result<void> DaemonStore::drop(std::string_view kind, std::string_view name) {
  const std::lock_guard lock(mutex_);
  if (!store_) return {};
  return store_->drop(kind, name);
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

StatusMessage::StorePart DaemonStore::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

}  // namespace ovws
