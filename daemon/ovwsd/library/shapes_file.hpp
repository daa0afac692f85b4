/// Measured spot shapes as JSON, for calibration files and recordings.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "core/base/result.hpp"
#include "core/spots/measured_spots.hpp"

namespace ovws {

/// Lit pixels as JSON. Decoding throws exceptions of the JSON library.
nlohmann::json lit_content(const LitPixels& lit);
LitPixels lit_from(const nlohmann::json& content);

/// Encodes measured spot shapes. Intensities and derivatives are preserved bit for bit.
nlohmann::json shapes_content(const MeasuredShapes& shapes);

/// Decodes measured spot shapes. `spots`: the calibration's number of spots; `leading_j`: the modes
/// of its matrix. Errc::invalid, field "shapes": parts are missing or inconsistent.
Result<MeasuredShapes> shapes_from(const nlohmann::json& content, int spots,
                                   const std::vector<int>& leading_j);

}  // namespace ovws
