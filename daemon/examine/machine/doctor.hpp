/// The selection of questions that `ovws doctor` asks: of this machine, and of a daemon. Asking
/// only reads, takes no control of a camera and opens no window, so that a daemon is not disturbed.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "daemon/examine/machine/machine.hpp"
#include "daemon/examine/status_questions.hpp"

namespace ovws::examine {

/// Requests system.status, config.get, the newest frame and, where it disturbs nothing, slm.verify
/// from the daemon at this endpoint.
using AskDaemon = std::function<DaemonFacts(const std::string& endpoint)>;
/// The daemon's answer. One that waits for a camera or display, or is at fault without a camera, is
/// asked again until it has run for 5 s, after this pause each time and twelve times in all at
/// most: it may be opening them, and then it controls a camera that it does not report.
DaemonFacts ask_opened(const AskDaemon& ask, const std::string& endpoint,
                       std::chrono::milliseconds pause = std::chrono::milliseconds(500));
DaemonsCamera camera_of(const DaemonFacts& facts);

/// Asks all questions; main thread, takes some seconds. Empty `path`: the settings that the daemon
/// uses if it answers on this machine; else the service's configuration, or the defaults. Empty
/// `endpoint`: the endpoint in the configuration. If the configuration cannot be loaded, what needs
/// it is `not_here`.
Findings examine_all(const std::string& path, const std::string& endpoint, const AskDaemon& ask);

}  // namespace ovws::examine
