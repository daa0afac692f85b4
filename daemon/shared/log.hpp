/// Where the log goes: stderr, with time for a person, with journal priorities under systemd.
#pragma once

#include <string>

namespace ovws {

/// `level`: trace, debug, info, warn, error.
void start_log(const std::string& level);
/// Thread-safe: from now on; the same names.
void set_log_level(const std::string& level);

}  // namespace ovws
