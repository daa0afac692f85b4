/// Differences between a configuration file and the configuration in use.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"

namespace ovws {

/// Dotted keys whose values differ.
struct ConfigDifference {
  std::vector<std::string> live;     ///< that can change at run time
  std::vector<std::string> restart;  ///< that need a restart
};

/// Whether this dotted key can change at run time.
bool changes_live(std::string_view key);

/// Compares two configurations key by key. Each entry of a list has a key of its own.
ConfigDifference difference(const Config& before, const Config& after);

/// Undoes the camera's rounding: a value of `file` that equals the value in use becomes the value
/// that was requested when the camera rounded to it.
CameraSettings as_requested(CameraSettings file, const CameraSnapshot& now);

/// `in_use`, but with the file's value where exactly that was requested of the camera: a rounded
/// value does not count as a change.
CameraSettings as_in_file(CameraSettings in_use, const CameraSettings& asked,
                          const CameraSettings& file);

}  // namespace ovws
