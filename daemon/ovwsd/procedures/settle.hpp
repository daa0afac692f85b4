/// The procedure of `slm.settle`.
#pragma once

#include "core/optics/geometry.hpp"
#include "core/optics/settle_time.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"
#include "proto/requests.hpp"

namespace ovws {

/// Moves one spot to and fro, and watches the light at both places in every frame that comes,
/// settled or not, from the moment the display took each picture. Errors: those of Bench and of
/// step_time.
Result<SettleTime> measure_settle(Bench& bench, const SlmGeometry& slm, const SettleRun& run);

}  // namespace ovws
