/// Checks requested camera settings against the device's limits.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "core/port/camera.hpp"

namespace ovws {

/// `wanted` with gain, pixel format and region checked. Errc::invalid: the first value out of
/// range, with field, value and range. With `clamp`, numbers are moved into their range instead,
/// exposure and frame rate, too; an unknown pixel format or a gain in the wrong unit remains an
/// error. Without `clamp` the camera itself checks exposure and frame rate when they are applied,
/// because their limits depend on region, format and each other.
Result<CameraSettings> within_limits(const CameraSettings& wanted, const CameraLimits& limits,
                                     bool clamp);

/// The error for a gain in dB, set or swept, with a camera that has none; requires
/// `limits.gain_raw`.
Error no_gain_in_db(std::string field, const CameraLimits& limits);

}  // namespace ovws
