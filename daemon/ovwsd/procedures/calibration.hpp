/// The procedure of `calibration.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Measures the interaction matrix by push-pull poking: shows each mode with both signs on top of
/// the current aberration, and averages the spots of settled frames. At the end the aberration
/// alone is shown again. Errors: those of Bench and of interaction_matrix; Errc::invalid, field
/// "modes": the lattice does not determine a requested mode; Errc::refused, field "modes": all
/// modes were requested, spots were lost, and a mode cannot be measured.
Result<MeasuredCalibration> measure_calibration(Bench& bench, const SlmGeometry& slm,
                                                const CalibrationRun& run);

}  // namespace ovws
