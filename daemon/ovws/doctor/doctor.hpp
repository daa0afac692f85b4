/// Runs all checks of a bench in sequence. They are read-only, take no control of a camera and open
/// no window, so that they do not disturb a running daemon.
#pragma once

#include <functional>
#include <string>

#include "daemon/ovws/doctor/daemon_answer.hpp"
#include "daemon/ovws/doctor/finding.hpp"

namespace ovws::doctor {

/// Requests system.status from the daemon at this endpoint.
using AskDaemon = std::function<DaemonFacts(const std::string& endpoint)>;

/// Main thread; takes some seconds. Empty `path`: the service's configuration, or the defaults.
/// Empty `endpoint`: the configuration's. If the configuration cannot be loaded, checks that depend
/// on it are `not_here`.
Findings examine(const std::string& path, const std::string& endpoint, const AskDaemon& ask);

}  // namespace ovws::doctor
