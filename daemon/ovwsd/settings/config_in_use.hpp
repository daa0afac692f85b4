/// The configuration in use: with it as its file, a restarted daemon would come back as it is now.
#pragma once

#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// Thread-safe: `started`, with the reloaded stream and log settings, and with the settings that
/// camera, sensor and refinement use now.
Config config_in_use(const Config& started, const LoadedConfig& loaded, const CameraActor& camera,
                     const SensorKeeper& keeper, const LiveRefiner& refiner);

}  // namespace ovws
