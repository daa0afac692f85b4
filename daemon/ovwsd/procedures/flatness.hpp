/// The procedure of `flatness.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"

namespace ovws {

/// Moves a lone bright spot's aperture all over the pupil (ScanGrid): without a slope its light
/// falls on one and the same place, so that its displacements are the slopes. Fits the modes
/// (ScanFit), shows their opposite, and scans again, until nothing changes. The aperture is smaller
/// than a subaperture by as much as makes the spot about as bright as the sensor's vortices. What
/// was in force before is part of the result. Tilts are the registration's. Without an origin.
/// Errors: those of Bench; Errc::refused without a registration, with a correction, if too few
/// spots are found, if no wavefront explains where they are, or if it does not converge.
Result<MeasuredFlatness> measure_flatness(Bench& bench, const SlmGeometry& slm, int frames);

}  // namespace ovws
