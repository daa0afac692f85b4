/// Daemon checks of `ovws doctor`: a daemon answers, has this version, and its status shows no
/// fault.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/ovws/doctor/camera.hpp"
#include "daemon/ovws/doctor/finding.hpp"

namespace ovws::doctor {

struct DaemonFacts {
  std::string endpoint;
  std::optional<nlohmann::json> status;  ///< the reply to system.status
  bool refused = false;                  ///< no status, because the daemon answered with an error
  std::string why;                       ///< why there is no status
  bool asks_for_keys = false;            ///< clients need keys: the configuration sets a secret key
  std::string own_version;               ///< version of this program
};

DaemonsCamera camera_of(const DaemonFacts& facts);
/// Whether the daemon answered and has the SLM's output open.
bool shows_holograms(const DaemonFacts& facts);
Findings judge(const DaemonFacts& facts);

}  // namespace ovws::doctor
