/// Does a daemon run, is it this program's, and what does it say of itself?
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/ovws/doctor/camera.hpp"
#include "daemon/ovws/doctor/finding.hpp"

namespace ovws::doctor {

struct DaemonFacts {
  std::string endpoint;
  std::optional<nlohmann::json> status;  ///< its answer to system.status
  bool refused = false;                  ///< without one: somebody answered with an error
  std::string why;                       ///< without one
  bool asks_for_keys = false;            ///< as the configuration says
  std::string own_version;               ///< this program's
};

DaemonsCamera camera_of(const DaemonFacts& facts);
Findings judge(const DaemonFacts& facts);

}  // namespace ovws::doctor
