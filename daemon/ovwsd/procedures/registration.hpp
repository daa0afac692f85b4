/// The procedure of `registration.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// Shows the base subaperture alone, with gratings that move its spot over most of the sensor's
/// field, and finds it each time: whatever the camera's angle, parity and scale. Base spot in
/// pixels of the camera's sensor. Errors: those of Bench; Errc::refused if the spot is not seen, or
/// does not move as a map says.
Result<Registration> measure_registration(Bench& bench, const SlmGeometry& slm, int frames);

}  // namespace ovws
