/// Checks and rounding of requested settings against the camera's limits, without device access.
#pragma once

#include <string>

#include "core/port/camera.hpp"

namespace ovws {

/// Rounds `wanted` to the nearest step of the increment. Errc::invalid, with the range in the
/// reason, if it is out of range or not finite. `what` names the value in the message: "a gain".
Result<double> fit_value(const std::string& field, const char* what, double wanted,
                         const Range<double>& range);

/// Step sizes of a region's offset, pixels; 0: the region cannot be moved.
struct RoiSteps {
  int x = 1, y = 1;
};

/// Rounds offset and size of a region down to the camera's steps. Errc::invalid if `wanted` does
/// not lie on the sensor, is smaller than the camera's minimum, or is displaced where the camera
/// cannot move it.
Result<Roi> fit_roi(const Roi& wanted, const CameraLimits& limits, RoiSteps steps);

/// Errc::invalid, with a list of the supported formats, if `wanted` is not among them.
Result<void> check_pixel_format(PixelFormat wanted, const CameraLimits& limits);

/// Errc::invalid if rows of packed pixels would not end at whole bytes, or if the region would
/// shift the Bayer pattern (odd x or y).
Result<void> check_region_suits_format(PixelFormat format, const Roi& roi);

/// Errc::invalid if the exposure is longer than the frame period, because cameras then silently
/// lower the rate. The field is the one that was changed (the exposure if both were).
Result<void> check_exposure_fits_rate(const CameraSettings& wanted, const CameraSettings& current);

/// Whether `applied`, read back from a streaming camera after a change from `before` to `wanted`,
/// differs in a setting that was not to change: the camera was reset meanwhile. Exposure and frame
/// rate limit each other, so one may follow the other.
bool has_unrequested_change(const CameraSettings& wanted, const CameraSettings& before,
                            const CameraSettings& applied);

}  // namespace ovws
