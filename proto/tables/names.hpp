/// The names that enumerations have on the wire and in the configuration file.
#pragma once

#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
#include "core/tracking/tracker.hpp"
#include "proto/field.hpp"
#include "proto/names.hpp"

namespace ovws {

template <>
struct Names<Grid> {
  static const auto& all() { return grid_names(); }
};
template <>
struct Names<HologramKind> {
  static const auto& all() { return pattern_names(); }
};
template <>
struct Names<ZernikeNorm> {
  static const auto& all() { return norm_names(); }
};
template <>
struct Names<PixelFormat> {
  static const auto& all() { return pixel_format_names(); }
};
template <>
struct Names<TrackerKind> {
  static const auto& all() { return tracker_names(); }
};
template <>
struct Names<TemplateKind> {
  static const auto& all() { return template_names(); }
};
template <>
struct Names<OperatorKind> {
  static const auto& all() { return operator_names(); }
};

}  // namespace ovws
