/// The configuration that a restart would need to come back as things are now.
#pragma once

#include "config/config.hpp"
#include "daemon/camera_actor.hpp"
#include "daemon/instrument.hpp"
#include "daemon/live_refiner.hpp"

namespace ovws {

/// Thread-safe: `base` with what camera, sensor and refinement use now.
Config config_in_use(Config base, const CameraActor& camera, const Instrument& instrument,
                     const LiveRefiner& refiner);

}  // namespace ovws
