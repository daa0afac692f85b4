/// Holds wanted camera settings against what the device can do.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "core/port/camera.hpp"

namespace ovws {

/// What depends on nothing else: gain, pixel format, region. The longest exposure and the highest
/// rate depend on region, format and each other, so that a camera judges them itself when they are
/// applied; here only `clamp` brings them into the present range. Errc::invalid with the field, the
/// value and the device's range; with `clamp` numbers are brought into range instead (a pixel
/// format cannot be). All or nothing.
Result<CameraSettings> within_limits(const CameraSettings& wanted, const CameraLimits& limits,
                                     bool clamp);

/// Why `gain_db` cannot be set, or a sweep through dB be run; only with `limits.gain_raw`.
Error no_gain_in_db(std::string field, const CameraLimits& limits);

}  // namespace ovws
