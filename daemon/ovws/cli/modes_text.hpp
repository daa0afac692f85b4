/// Aberrations as a person types them: "2,-2:0.5;4,0:0.1".
#pragma once

#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/zernike.hpp"

namespace ovws::cli {

/// RMS-normalised modes; empty text: none. Errors (Errc::invalid, field "modes") name the part at
/// fault; text without a mode, a lone ";", is one, and a mode given twice.
Result<std::vector<Mode>> parse_modes(const std::string& text, ZernikeNorm norm);

}  // namespace ovws::cli
