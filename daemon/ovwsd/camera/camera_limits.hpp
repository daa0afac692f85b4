/// Checks requested camera settings against the device's limits.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "core/port/camera.hpp"

namespace ovws {

/// Checks the settings whose limits depend on no other: gain, pixel format, region. The limits of
/// exposure and frame rate depend on region, format and each other, so the camera checks them
/// itself when they are applied; here `clamp` only clamps them to the present limits. Errc::invalid
/// with the field, the value and the device's range; with `clamp`, numbers are clamped instead (a
/// pixel format cannot be). All or nothing.
Result<CameraSettings> within_limits(const CameraSettings& wanted, const CameraLimits& limits,
                                     bool clamp);

/// The error for a gain in dB, set or swept, with a camera that has none; requires
/// `limits.gain_raw`.
Error no_gain_in_db(std::string field, const CameraLimits& limits);

}  // namespace ovws
