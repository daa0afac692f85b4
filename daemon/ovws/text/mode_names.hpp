/// Zernike modes by name or number, as people write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/zernike.hpp"

namespace ovws::cli {

/// OSA/ANSI index j of the mode that `text` names: by j ("7"), by n,m ("3,-1"), or by its common
/// name with hyphens, underscores or spaces ("vertical-coma"). Words of a name may be left out if
/// only one name has the others: "spherical" is primary-spherical. "secondary" is never implied.
/// Errors (Errc::invalid, field "modes"): an ambiguous name, with its candidates, as for "coma";
/// text that is no mode, with the nearest name.
Result<int> mode_of(std::string_view text);

/// Width of the longest name of these modes, characters.
std::size_t longest_name(const std::vector<int>& modes_j);

/// All common names with hyphens: "piston", "vertical-tilt", …
const std::vector<std::string>& mode_names();

/// Parses aberrations: "2,-2:0.5;defocus:0.1", see mode_of.
/// Returns RMS-normalised modes; none for empty text. Errors (Errc::invalid, field "modes") quote
/// the invalid part. Text that has only separators, or a mode given twice, is an error.
Result<std::vector<Mode>> parse_modes(const std::string& text, ZernikeNorm norm);

}  // namespace ovws::cli
