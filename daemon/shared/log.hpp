/// The log on standard error: with time stamps, or with journal priorities under systemd.
#pragma once

#include "config/config.hpp"

namespace ovws {

void start_log(LogLevel level);
/// Changes the level of all later messages. Thread-safe.
void set_log_level(LogLevel level);

}  // namespace ovws
