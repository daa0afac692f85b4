/// Whether a configuration that reads well also makes a sensor.
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// Errors as the daemon's start would give them: drivers that do not exist, LUT and flatness files,
/// lattice, tracker. Endpoints and keys are check_security's. Opens no device.
Result<void> check_usable(const Config& config);
/// Errc::invalid (field "sensor.spacing" or "camera.roi") if the camera region cannot see the
/// spots, or the tracker cannot tell them apart, by this configuration alone; see spot_layout.hpp.
Result<void> check_sees_spots(const Config& config);

}  // namespace ovws
