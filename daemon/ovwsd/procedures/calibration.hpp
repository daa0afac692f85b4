/// The procedure of `calibration.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Shows each mode with both signs on top of the aberration that is shown, and averages the spots
/// of settled frames; at the end, that aberration alone is shown again. Errors: those of Bench and
/// of interaction_matrix; Errc::invalid, field "modes", for a mode that the lattice does not tell.
Result<MeasuredCalibration> measure_calibration(Bench& bench, const SlmGeometry& slm,
                                                const CalibrationRun& run);

}  // namespace ovws
