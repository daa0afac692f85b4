/// What a configuration's file asks for beyond what is in use.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"

namespace ovws {

/// Dotted keys whose values differ.
struct ConfigDifference {
  std::vector<std::string> live;     ///< that can change while the daemon runs
  std::vector<std::string> restart;  ///< that wait for a restart
};

/// Whether this dotted key can change while the daemon runs.
bool changes_live(std::string_view key);

/// A list of which `after` has other entries is named by each entry that differs.
ConfigDifference difference(const Config& before, const Config& after);

/// A camera rounds: a file with what it made of a value asks for the value that it made it of.
CameraSettings as_asked(CameraSettings file, const CameraSnapshot& now);

/// `in_use`, but with the file's value where the camera was asked for that one: rounding is no
/// change of the file.
CameraSettings as_in_file(CameraSettings in_use, const CameraSettings& asked,
                          const CameraSettings& file);

}  // namespace ovws
