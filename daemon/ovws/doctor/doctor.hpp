/// All checks of a bench, one after the other. Nothing is changed, no camera's control is taken, no
/// window is opened: a daemon that runs does not notice.
#pragma once

#include <functional>
#include <string>

#include "daemon/ovws/doctor/daemon_answer.hpp"
#include "daemon/ovws/doctor/finding.hpp"

namespace ovws::doctor {

/// Asks a daemon for its status, at this endpoint.
using AskDaemon = std::function<DaemonFacts(const std::string& endpoint)>;

/// Main thread, takes some seconds. Empty `path`: the service's configuration, or the defaults.
/// Empty `endpoint`: the configuration's. With a configuration that does not read well, what
/// depends on it is `not_here`.
Findings examine(const std::string& path, const std::string& endpoint, const AskDaemon& ask);

}  // namespace ovws::doctor
