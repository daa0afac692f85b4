/// The procedure of `flatness.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"

namespace ovws {

/// Measures the flatness error of the SLM and the optics by scanning a single aperture with a
/// bright spot over the pupil (ScanGrid). All positions use the same grating, so the spot's
/// displacements are the local slopes. Fits the modes (ScanFit), shows their opposite and scans
/// again until they no longer change. The aperture is smaller than a subaperture, which makes the
/// spot about as bright as the sensor's vortices. The result includes the previously active
/// flatness, but no tilts, which belong to the registration; its origin is not set. Errors: those
/// of Bench and ScanFit::fit. Errc::refused: no registration, a correction is active, or a flatness
/// of another pupil is active. Errc::refused: no wavefront explains the positions, or the iteration
/// does not converge.
Result<MeasuredFlatness> measure_flatness(Bench& bench, const SlmGeometry& slm, int frames);

}  // namespace ovws
