/// The settings in use: what is in the files, what was requested since, and how they differ.
#pragma once

#include <atomic>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/fitter/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "daemon/shared/guarded.hpp"

namespace ovws {

/// The daemon's settings as one configuration. Each value is stored once: those that can change at
/// run time by the part that applies them, all others here. Thread-safe.
class Settings {
 public:
  /// The parts must outlive this object.
  Settings(LoadedConfig loaded, const CameraActor& camera, const SlmLoop& slm,
           const SensorKeeper& keeper, const LiveRefiner& refiner)
      : started_(loaded.effective),
        loaded_(std::move(loaded)),
        camera_(camera),
        slm_(slm),
        keeper_(keeper),
        refiner_(refiner) {}

  /// The configuration at the daemon's start.
  const Config& started() const { return started_; }
  /// Increases before a request to save settings is carried out, and before its lease ends.
  int saves() const { return saves_.load(); }
  void count_save() { ++saves_; }
  /// What was loaded last, at the start or by a reload.
  LoadedConfig loaded() const { return loaded_.get(); }
  void set_loaded(LoadedConfig loaded) { loaded_.set(std::move(loaded)); }

  /// The settings in use; those of the camera as it has rounded them.
  Config in_use() const { return with(camera_.snapshot()); }
  /// The same, with the camera's settings as they were requested. A daemon that starts with it as
  /// its file has the present settings.
  Config requested() const;

 private:
  Config with(const CameraSnapshot& camera) const;

  const Config started_;
  Guarded<LoadedConfig> loaded_;
  std::atomic<int> saves_{0};
  const CameraActor& camera_;
  const SlmLoop& slm_;
  const SensorKeeper& keeper_;
  const LiveRefiner& refiner_;
};

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

}  // namespace ovws
