/// The configuration in use, and how it differs from a configuration file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// Thread-safe: `started`, with the reloaded stream and log settings, and with the settings that
/// camera, sensor and refinement use now. With it as its file, a restarted daemon would come back
/// as it is now.
Config config_in_use(const Config& started, const LoadedConfig& loaded, const CameraActor& camera,
                     const SensorKeeper& keeper, const LiveRefiner& refiner);

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
