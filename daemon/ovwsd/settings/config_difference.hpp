/// Configuration in use, and its differences from a configuration file.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// Configuration in use: `started` with the reloaded stream and log settings, and the current
/// settings of camera, SLM, sensor and refinement. A daemon that starts with it as its file has the
/// present settings. Thread-safe.
Config config_in_use(const Config& started, const LoadedConfig& loaded, const CameraActor& camera,
                     const SlmLoop& slm, const SensorKeeper& keeper, const LiveRefiner& refiner);

/// Dotted keys whose values differ.
struct ConfigDifference {
  std::vector<std::string> live;     ///< keys that can change at run time
  std::vector<std::string> restart;  ///< keys that need a restart
};

/// True if the setting with this dotted key can change at run time.
bool changes_live(std::string_view key);

/// The configuration as one flat JSON object of JSON pointers and values. Each entry of a list has
/// its own pointer; a mask is one value.
nlohmann::json flat(const Config& config);

/// Compares two configurations key by key, by the keys of `flat`. The sensor of a fixed array is
/// hardware: its keys need a restart.
ConfigDifference difference(const Config& before, const Config& after);

/// Undoes the camera's rounding. A value of `file` that equals the value in use is replaced by the
/// requested value, which the camera had rounded.
CameraSettings as_requested(CameraSettings file, const CameraSnapshot& now);

/// Returns `in_use` with the file's value wherever `asked` equals the file's value, so that a value
/// that the camera rounded does not count as a change.
CameraSettings as_in_file(CameraSettings in_use, const CameraSettings& asked,
                          const CameraSettings& file);

}  // namespace ovws
