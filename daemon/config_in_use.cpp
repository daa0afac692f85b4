#include "daemon/config_in_use.hpp"

namespace ovws {

Config config_in_use(Config base, const CameraActor& camera, const Instrument& instrument,
                     const LiveRefiner& refiner) {
  const SensorSnapshot sensor = instrument.snapshot();
  base.camera.settings = camera.snapshot().settings;
  base.sensor = sensor.sensor;
  base.tracking = sensor.tracking;
  base.refine = in_format(refiner.settings(), base.camera.settings.pixel_format);
  return base;
}

}  // namespace ovws
