/// Checks whether a configuration that was read without errors also describes a usable sensor.
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// Validates what parsing cannot: driver names, CPU numbers, LUT and flatness files, lattice and
/// tracker settings. Called at start, at reload and by `ovws doctor`; opens no device. Endpoints
/// and keys: see check_security.
Result<void> check_usable(const Config& config);
/// Errc::invalid (field "sensor.spacing" or "camera.roi") if, by this configuration alone, the
/// spots fall outside the camera's region or are too close for the tracker; see spot_layout.hpp.
Result<void> check_sees_spots(const Config& config);

}  // namespace ovws
