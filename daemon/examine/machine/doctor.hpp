/// Bench checks, run in sequence. A check only reads, takes no control of a camera and opens no
/// window, so that a running daemon is not disturbed.
#pragma once

#include <string>

#include "daemon/examine/machine/daemon_answer.hpp"
#include "daemon/examine/machine/finding.hpp"

namespace ovws::doctor {

/// Runs all checks; main thread, takes some seconds. Empty `path`: the settings that the
/// daemon uses if it answers on this machine; else the service's configuration, or the defaults.
/// Empty `endpoint`: the endpoint in the configuration. If the configuration cannot
/// be loaded, checks that need it are `not_here`.
Findings examine(const std::string& path, const std::string& endpoint, const AskDaemon& ask);

}  // namespace ovws::doctor
