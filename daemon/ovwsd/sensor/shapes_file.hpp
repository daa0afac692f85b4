/// Measured shapes in the file of a calibration, and in recordings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/base/result.hpp"
#include "core/spots/measured_spots.hpp"

namespace ovws {

/// Light and derivatives are kept bit for bit.
nlohmann::json shapes_content(const MeasuredShapes& shapes);

/// `spots`: of the calibration; its matrix is of `leading_j`. Errc::invalid, field "shapes": parts
/// are missing or do not fit these, or each other.
Result<MeasuredShapes> shapes_from(const nlohmann::json& content, int spots,
                                   const std::vector<int>& leading_j);

}  // namespace ovws
