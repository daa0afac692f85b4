/// Checks requested camera settings against the device's limits.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "core/port/camera.hpp"

namespace ovws {

/// Checks gain, pixel format and region of `wanted`. Errc::invalid: the first value out of range,
/// with field, value and range. With `clamp`, clamps numbers to their range instead, also exposure
/// and frame rate; an unknown pixel format or a gain in the wrong unit remains an error. Without
/// `clamp`, the camera checks exposure and frame rate when they are applied, because their limits
/// depend on region, format and each other.
Result<CameraSettings> within_limits(const CameraSettings& wanted, const CameraLimits& limits,
                                     bool clamp);

/// Error for a gain in dB that is set or swept on a camera without gain in dB. Requires
/// `limits.gain_raw`.
Error no_gain_in_db(std::string field, const CameraLimits& limits);

}  // namespace ovws
