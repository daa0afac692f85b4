/// The procedure of `lut.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/slm/slm_measured.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Measures the SLM's phase response by interference of two patches of the pupil
/// (core/optics/grey_fringe.hpp). One patch shows each grey level in turn, upwards and then
/// downwards, the other a fixed level. The patches are as large as possible without saturating the
/// camera. The result's origin is not set. Errors: those of Bench and of phase_response;
/// Errc::refused: the spot is saturated or too dark.
Result<MeasuredLut> measure_lut(Bench& bench, const SlmGeometry& slm, const LutRun& run);

}  // namespace ovws
