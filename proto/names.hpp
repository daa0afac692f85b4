/// The names that enumerations have on the wire and in the configuration, in the enumerations'
/// own order.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

const std::vector<std::string>& grid_names();
const std::vector<std::string>& pattern_names();
const std::vector<std::string>& showable_pattern_names();  ///< all but `test`, reserved for jobs
const std::vector<std::string>& norm_names();
const std::vector<std::string>& pixel_format_names();
const std::vector<std::string>& tracker_names();
const std::vector<std::string>& template_names();
const std::vector<std::string>& operator_names();

std::string_view pattern_name(HologramKind kind);
std::string_view template_name(TemplateKind kind);
std::string_view operator_name(OperatorKind kind);

}  // namespace ovws
