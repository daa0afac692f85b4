/// The procedure of `registration.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "core/wavefront/registration.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// Registers the camera to the SLM. Shows the base subaperture alone with several gratings, which
/// move its spot over most of the field. Then fits an affine map to the spot's positions. Works for
/// any rotation, parity and scale. The base spot is in pixels of the camera's whole sensor. Errors:
/// those of Bench; Errc::refused: the spot is not found, or no affine map fits its positions.
Result<Registration> measure_registration(Bench& bench, const SlmGeometry& slm, int frames);

}  // namespace ovws
