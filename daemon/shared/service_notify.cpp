#include "daemon/shared/service_notify.hpp"

#include <systemd/sd-daemon.h>

#include <cinttypes>

#include "core/port/clock.hpp"

namespace ovws::service {

void notify_ready() {
  sd_notify(0, "READY=1");
}
void notify_reloading() {
  // systemd requires the time, to distinguish several reloads.
  sd_notifyf(0, "RELOADING=1\nMONOTONIC_USEC=%" PRIi64, monotonic_ns() / 1000);
}
void notify_stopping() {
  sd_notify(0, "STOPPING=1");
}
void notify_extend(double seconds) {
  sd_notifyf(0, "EXTEND_TIMEOUT_USEC=%" PRIi64, std::int64_t(1e6 * seconds));
}
void notify_status(const std::string& text) {
  sd_notify(0, ("STATUS=" + text).c_str());
}
void notify_watchdog() {
  sd_notify(0, "WATCHDOG=1");
}

std::uint64_t watchdog_interval_us() {
  std::uint64_t interval_us = 0;
  return sd_watchdog_enabled(0, &interval_us) > 0 ? interval_us : 0;
}

}  // namespace ovws::service
