#include "daemon/ovwsd/settings/config_in_use.hpp"

namespace ovws {

Config config_in_use(const Config& started, const LoadedConfig& loaded, const CameraActor& camera,
                     const SensorKeeper& keeper, const LiveRefiner& refiner) {
  const SensorView sensor = keeper.snapshot();
  Config now = started;
  now.stream.image_rate_hz = loaded.effective.stream.image_rate_hz;
  now.log.level = loaded.effective.log.level;
  now.camera.settings = camera.snapshot().settings;
  now.sensor = sensor->sensor;
  now.tracking = sensor->tracking;
  now.refine = in_format(refiner.settings(), now.camera.settings.pixel_format);
  return now;
}

}  // namespace ovws
