/// Zernike modes by name or number, as people write them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"

namespace ovws::cli {

/// OSA/ANSI index j of the mode that `text` names: by j ("7"), by n,m ("3,-1"), or by its common
/// name with hyphens, underscores or spaces ("vertical-coma"). Words of a name may be left out if
/// only one name has the others: "spherical" is primary-spherical. "secondary" is never implied.
/// Errors (Errc::invalid, field "modes"): an ambiguous name, with its candidates, as for "coma";
/// text that is no mode, with the nearest name.
Result<int> mode_of(std::string_view text);

/// All common names with hyphens: "piston", "vertical-tilt", …
const std::vector<std::string>& mode_names();

}  // namespace ovws::cli
