/// systemd notifications (sd_notify): READY, RELOADING, STATUS, WATCHDOG, STOPPING. Without systemd
/// every call does nothing.
#pragma once

#include <cstdint>
#include <string>

namespace ovws::service {

void notify_ready();
/// Call notify_ready when the reload is finished, whether it succeeded or not.
void notify_reloading();
void notify_stopping();
/// Extends the timeout of the start, or of the stop: it may take `seconds` more from now on.
void notify_extend(double seconds);
void notify_status(const std::string& text);
void notify_watchdog();
/// The watchdog timeout, us; 0: no watchdog.
std::uint64_t watchdog_interval_us();

}  // namespace ovws::service
