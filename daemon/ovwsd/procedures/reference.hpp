/// The procedure of `reference.take`.
#pragma once

#include <nlohmann/json.hpp>

#include "daemon/ovwsd/procedures/bench.hpp"
#include "proto/tables/params.hpp"

namespace ovws {

/// Errc::refused: the SLM does not show the sensor; or, field "allow_aberration", an aberration is
/// introduced, which would become part of the reference.
Result<void> can_take_reference(const SensorSnapshot& sensor, const ReferenceTake& take);

/// Takes a reference: averages the spots of settled frames and the pixels of some of them,
/// activates the result and returns the job's result. Errors: those of can_take_reference, Bench
/// and use_reference; Errc::refused, field "camera": the camera's settings changed meanwhile.
Result<nlohmann::json> take_reference(Bench& bench, const ReferenceTake& take);

}  // namespace ovws
