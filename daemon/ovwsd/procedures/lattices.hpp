/// Procedure of `lattice.prepare`.
#pragma once

#include <nlohmann/json.hpp>

#include "core/optics/geometry.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "daemon/ovwsd/sensor/prepared_lattices.hpp"
#include "proto/tables/lattices.hpp"

namespace ovws {

/// Shows each lattice in turn without an introduced aberration, finds its exposure, takes its
/// reference and, if requested, its calibration, and keeps it in `prepared`. The job can be
/// cancelled until it ends; finished lattices stay. Returns the job's result. Errors: those of
/// find_exposure, take_reference and measure_calibration, with the lattice's name.
Result<nlohmann::json> prepare_lattices(Bench& bench, const SlmGeometry& slm,
                                        const LatticePrepare& asked, PreparedLattices& prepared);

}  // namespace ovws
