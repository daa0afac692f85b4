/// What of the settings asked for a camera can do, decided without asking it.
#pragma once

#include <string>

#include "core/port/camera.hpp"

namespace ovws {

/// The value nearest to `wanted` that the increment allows, or Errc::invalid (with the range in
/// the reason) if it lies outside or is not a number. `what` names it for people: "gain".
Result<double> fit_value(const std::string& field, const char* what, double wanted,
                         const Range<double>& range);

/// How far apart the places are where a region may begin; 0: the region cannot be moved.
struct RoiSteps {
  int x = 1, y = 1;
};

/// The region moved back and made smaller to the next step that the camera allows; Errc::invalid if
/// `wanted` does not lie on the sensor, or is smaller than the camera's smallest.
Result<Roi> fit_roi(const Roi& wanted, const CameraLimits& limits, RoiSteps steps);

/// Errc::invalid, naming the formats that there are.
Result<void> check_pixel_format(PixelFormat wanted, const CameraLimits& limits);

/// Errc::invalid if rows of packed pixels would not end at whole bytes, or a colour filter's square
/// not begin with the region.
Result<void> check_region_suits_format(PixelFormat format, const Roi& roi);

/// Errc::invalid if an exposure is longer than the frame period: cameras then silently lower the
/// rate, and nobody would know. The field is the one of the two that is to change.
Result<void> check_exposure_fits_rate(const CameraSettings& wanted, const CameraSettings& current);

/// Whether `applied`, read back from a streaming camera that was brought from `before` to `wanted`,
/// holds a change that nobody asked for: it was reset meanwhile. Exposure and frame rate limit each
/// other, so that one may move with the other.
bool changed_unasked(const CameraSettings& wanted, const CameraSettings& before,
                     const CameraSettings& applied);

}  // namespace ovws
