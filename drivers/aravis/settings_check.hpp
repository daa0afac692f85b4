/// Camera settings check: rounds requested settings and compares them with the camera's limits,
/// without device access.
#pragma once

#include <string>

#include "core/port/camera.hpp"

namespace ovws {

/// Rounds `wanted` to the nearest step of the range. Errc::invalid, with the range in the reason,
/// if `wanted` is out of range or not finite. `what` names the value in the message: "a gain".
Result<double> fit_value(const std::string& field, const char* what, double wanted,
                         const Range<double>& range);

/// Step sizes of a region's offset, pixels; 0: the region cannot be moved along this axis.
struct RoiSteps {
  int x = 1, y = 1;
};

/// Rounds offset and size of a region down to the camera's steps. Errc::invalid if `wanted` does
/// not lie on the sensor, is smaller than the camera's minimum, or has an offset along an axis on
/// which the camera cannot move the region.
Result<Roi> fit_roi(const Roi& wanted, const CameraLimits& limits, RoiSteps steps);

/// Checks the pixel format. Errc::invalid, with a list of the camera's formats, if `wanted` is not
/// one of them.
Result<void> check_pixel_format(PixelFormat wanted, const CameraLimits& limits);

/// Checks that the region suits the pixel format. Errc::invalid if rows of packed pixels would end
/// within a byte, or if an odd x or y would shift the Bayer pattern.
Result<void> check_region_suits_format(PixelFormat format, const Roi& roi);

/// Checks that the exposure is not longer than the frame period, because cameras would silently
/// lower the frame rate. Errc::invalid names the changed field (exposure_us if exposure and rate
/// changed).
Result<void> check_exposure_fits_rate(const CameraSettings& wanted, const CameraSettings& current);

/// Detects the reset of a streaming camera: whether `applied`, read back after a change from
/// `before` to `wanted`, differs in a setting that was to stay. Do not use it with the stream
/// stopped: a new region or format may change exposure or rate. Exposure and rate limit each other,
/// so a change of one may change the other without a reset.
bool has_unrequested_change(const CameraSettings& wanted, const CameraSettings& before,
                            const CameraSettings& applied);

}  // namespace ovws
