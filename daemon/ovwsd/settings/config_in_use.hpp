/// The configuration that a restart would need to come back as things are now.
#pragma once

#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/settings/saved_config.hpp"

namespace ovws {

/// Thread-safe: `started` with what was reloaded of streams and log, and with what camera, sensor
/// and refinement use now.
Config config_in_use(const Config& started, const LoadedConfig& loaded, const CameraActor& camera,
                     const SensorKeeper& keeper, const LiveRefiner& refiner);

}  // namespace ovws
