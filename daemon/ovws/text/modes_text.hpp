/// Parses aberrations from text: "2,-2:0.5;defocus:0.1", see mode_of for the modes.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/zernike.hpp"

namespace ovws::cli {

/// Parses RMS-normalised modes; none for empty text. Errors (Errc::invalid, field "modes") quote
/// the invalid part. Text that has only separators, or a mode given twice, is an error.
Result<std::vector<Mode>> parse_modes(const std::string& text, ZernikeNorm norm);

}  // namespace ovws::cli
