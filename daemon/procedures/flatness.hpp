/// The procedure of `flatness.run`.
#pragma once

#include "core/optics/geometry.hpp"
#include "daemon/procedures/bench.hpp"
#include "daemon/slm_measured.hpp"

namespace ovws {

/// Reads the modes from where the diffraction model has the spots of a flat sensor, shows their
/// opposite, and again, until only noise is left: near the end spots are where the model has them,
/// so that neither the slopes nor the interference of neighbours matter. What was in force before
/// is part of the result. Tilts are the registration's. Without an origin. Errors: those of Bench;
/// Errc::refused without a registration, with a correction, if too few spots are found, or if it
/// does not converge.
Result<MeasuredFlatness> measure_flatness(Bench& bench, const SlmGeometry& slm, int frames);

}  // namespace ovws
