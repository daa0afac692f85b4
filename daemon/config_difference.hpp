/// What a configuration's file asks for beyond what is in use.
#pragma once

#include <string>
#include <vector>

#include "config/config.hpp"
#include "daemon/camera_actor.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Dotted keys whose values differ.
struct ConfigDifference {
  std::vector<std::string> live;     ///< that can change while the daemon runs
  std::vector<std::string> restart;  ///< that wait for a restart
};

/// A list of which `after` has other entries is named by each entry that differs.
ConfigDifference difference(const Config& before, const Config& after);

/// A camera rounds: a file with what it made of a value asks for the value that it made it of.
CameraSettings as_asked(CameraSettings file, const CameraSnapshot& now);

/// Only what differs.
CameraSet camera_change(const CameraSettings& before, const CameraSettings& after);

}  // namespace ovws
