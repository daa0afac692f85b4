/// A calibration as JSON, for its file.
#pragma once

#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/ovwsd/sensor/calibration.hpp"

namespace ovws {

/// What a file holds of a calibration, and back: the matrix and its standard errors bit for bit;
/// the comparison with the model is not in it. `config`: where the optics and the SLM come from if
/// no registration was in force. Errors (Errc::invalid) say what does not fit together.
nlohmann::json calibration_content(const Calibration& calibration);
Result<Calibration> calibration_from(const nlohmann::json& content, const Config& config);

}  // namespace ovws
