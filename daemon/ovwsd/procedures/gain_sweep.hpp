/// The procedure of `experiment.gain_sweep`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/procedures/experiment_archive.hpp"

namespace ovws {

/// Measures what of `run` the archive does not have, and puts it there: first the reference of each
/// arm, without an aberration, then cell by cell. Modes by the tracker's slopes. A run that has
/// references already goes on only where the spots of one still stand (check_unmoved). Errors:
/// those of Bench, of show_request and of the camera; Errc::refused if a reference is
/// saturated, or its spots are lost or have moved.
Result<void> measure_gain_sweep(Bench& bench, const SlmGeometry& slm, const ExperimentRun& run,
                                ExperimentArchive& archive);

}  // namespace ovws
