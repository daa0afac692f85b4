/// Holds wanted camera settings against what the device can do.
#pragma once

#include "core/port/camera.hpp"

namespace ovws {

/// What depends on nothing else: gain, pixel format, region. The longest exposure and the highest
/// rate depend on region, format and each other, so that a camera judges them itself when they are
/// applied; here only `clamp` brings them into the present range. Errc::invalid with the field, the
/// value and the device's range; with `clamp` numbers are brought into range instead (a pixel
/// format cannot be). All or nothing.
Result<CameraSettings> within_limits(const CameraSettings& wanted, const CameraLimits& limits,
                                     bool clamp);

}  // namespace ovws
