/// The procedure of `reference.take`.
#pragma once

#include <nlohmann/json.hpp>

#include "daemon/ovwsd/procedures/bench.hpp"
#include "proto/tables/params.hpp"

namespace ovws {

/// Errc::refused: the SLM does not show the sensor; field "allow_aberration": an aberration is
/// introduced, which the reference would hold.
Result<void> can_take_reference(const SensorSnapshot& sensor, const ReferenceTake& take);

/// Averages the spots of settled frames, and some of the frames, and puts them to use; returns the
/// job's result. Errors: those of can_take_reference, of Bench and of use_reference;
/// Errc::refused, field "camera", if its settings changed meanwhile.
Result<nlohmann::json> take_reference(Bench& bench, const ReferenceTake& take);

}  // namespace ovws
