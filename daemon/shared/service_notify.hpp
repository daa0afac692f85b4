/// What systemd hears of us: READY, RELOADING, STATUS, WATCHDOG, STOPPING. Without systemd every
/// call does nothing.
#pragma once

#include <cstdint>
#include <string>

namespace ovws::service {

void notify_ready();
/// To be followed by notify_ready when it is done, whatever came of it.
void notify_reloading();
void notify_stopping();
/// Work at the end takes so much longer, from now on.
void notify_extend(double seconds);
void notify_status(const std::string& text);
void notify_watchdog();
/// How often the watchdog wants to be fed at the latest, us; 0: not watched.
std::uint64_t watchdog_interval_us();

}  // namespace ovws::service
