/// The procedure of `lut.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Shows two patches of the pupil that beat with each other (core/optics/grey_fringe.hpp), the one
/// with each grey level in turn, up and down again, as large as the camera's range allows. Without
/// an origin. Errors: those of Bench and of phase_response; Errc::refused if the spot is saturated
/// or dark.
Result<MeasuredLut> measure_lut(Bench& bench, const SlmGeometry& slm, const LutRun& run);

}  // namespace ovws
