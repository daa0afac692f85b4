#include "daemon/ovwsd/actor/events.hpp"

#include <spdlog/spdlog.h>

#include "core/base/printable.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"

namespace ovws {
namespace {

/// Limit of an event's text in bytes, because it may quote a device or a client.
constexpr std::size_t kMaxTextBytes = 2000;

spdlog::level::level_enum log_level(Severity severity) {
  switch (severity) {
    case Severity::info:
      return spdlog::level::info;
    case Severity::warning:
      return spdlog::level::warn;
    case Severity::error:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

}  // namespace

void Events::emit(std::string kind, Severity severity, std::string text, nlohmann::json data) {
  text = printable(text, kMaxTextBytes);
  spdlog::log(log_level(severity), "{}", text);
  queue_.put(
      EventMessage{0, utc_ns(), std::move(kind), severity, std::move(text), std::move(data)});
  queue_.request_status();
}

void Events::status_changed() {
  queue_.request_status();
}

}  // namespace ovws
