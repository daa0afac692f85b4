/// The procedure of `slm.settle`.
#pragma once

#include "core/optics/geometry.hpp"
#include "core/optics/settle_time.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Measures the SLM's settle time. Moves one spot to and fro, and records the intensity at both
/// places in every frame, settled or not. Times count from the moment the display presented each
/// hologram. Errors: those of Bench, Bench::check_shown and step_time.
Result<SettleTime> measure_settle(Bench& bench, const SlmGeometry& slm, const SettleRun& run);

}  // namespace ovws
