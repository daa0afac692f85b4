/// Model of a loop's disturbance from JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.hpp"
#include "core/control/loop_model.hpp"

namespace ovws {

/// Reads the list `modes` of `loop.model`, and of a recording's document "loop". Only what the
/// control laws use is read, not the forecasts. Errc::invalid, field "modes".
Result<LoopModel> loop_model_from(const nlohmann::json& modes);

}  // namespace ovws
