/// Configuration checks after parsing: whether the values describe a usable sensor.
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// Validates values that the parser cannot check: driver names, CPU numbers, LUT and flatness
/// files, lattice and tracker settings. Called at start, at reload and by `ovws doctor`; opens no
/// device. Endpoints and keys: see check_security.
Result<void> check_usable(const Config& config);
/// The part of check_usable that judges the sensor on its bench: pupil, number of subapertures,
/// gratings, spot size, tracker. Reads no file; takes well below a millisecond.
Result<void> check_sensor(const Config& config);
/// Checks the spot layout by the configuration alone. Errc::invalid (field "sensor.spacing" or
/// "camera.roi"): spots fall outside the camera's region or are too close for the tracker; see
/// spot_layout.hpp.
Result<void> check_sees_spots(const Config& config);
/// Whether the SLM's zeroth order falls outside the camera's region, by the configuration alone;
/// see spot_layout.hpp. A bench inside of which it falls may measure, with saturated pixels.
Result<void> check_zeroth_order(const Config& config);

}  // namespace ovws
