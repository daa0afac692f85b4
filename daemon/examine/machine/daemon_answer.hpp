/// Daemon checks of `ovws doctor`: a daemon answers, has this version, its status shows no fault
/// and no slow camera, the image is neither dark nor too bright, and the SLM's output shows the
/// hologram.
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/examine/machine/camera.hpp"
#include "daemon/examine/machine/finding.hpp"

namespace ovws::doctor {

struct DaemonFacts {
  std::string endpoint;
  std::optional<nlohmann::json> status;  ///< the reply to system.status
  std::optional<double> saturated;       ///< fraction of the newest frame's spots; none: no frame
  std::optional<Config> config;          ///< the settings in use, by config.get; none: not known
  std::optional<nlohmann::json> levels;  ///< the reply to slm.verify; none: not called, or refused
  std::string why_no_levels;             ///< why there is none although it shows holograms
  bool refused = false;                  ///< no status, because the daemon answered with an error
  std::string why;                       ///< why there is no status
  bool asks_for_keys = false;            ///< clients need keys: the configuration sets a secret key
  std::string own_version;               ///< version of this program
};

/// Requests system.status, config.get, the newest frame and, where it disturbs nothing, slm.verify
/// from the daemon at this endpoint.
using AskDaemon = std::function<DaemonFacts(const std::string& endpoint)>;
/// The daemon's answer. One that waits for a camera or display, or is at fault without a camera, is
/// asked again until it has run for 5 s, after this pause each time and twelve times in all at
/// most: it may be opening them, and then it controls a camera that it does not report.
DaemonFacts ask_opened(const AskDaemon& ask, const std::string& endpoint,
                       std::chrono::milliseconds pause = std::chrono::milliseconds(500));

DaemonsCamera camera_of(const DaemonFacts& facts);
/// Whether the daemon answered and has the SLM's output open.
bool shows_holograms(const DaemonFacts& facts);
/// Why slm.verify would disturb this bench: it delays holograms. Empty: it does not.
std::string why_not_verify(const DaemonFacts& facts);
/// The folder in which the daemon stores its state, and why it stores nothing or not all, as its
/// status says.
std::optional<std::string> state_folder_of(const DaemonFacts& facts);
std::string store_fault_of(const DaemonFacts& facts);
/// Why the daemon finds no spots, as its status says; empty: it does not say so.
std::string layout_fault_of(const DaemonFacts& facts);
Findings judge(const DaemonFacts& facts);

}  // namespace ovws::doctor
