/// Where the log goes: stderr, with time for a person, with journal priorities under systemd.
#pragma once

#include "config/config.hpp"

namespace ovws {

void start_log(LogLevel level);
/// Thread-safe: from now on.
void set_log_level(LogLevel level);

}  // namespace ovws
