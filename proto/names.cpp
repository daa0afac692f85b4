#include "proto/names.hpp"

#include "core/base/image.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

const std::vector<std::string>& grid_names() {
  static const std::vector<std::string> names{"hexagonal", "square"};
  return names;
}

const std::vector<std::string>& pattern_names() {
  static const std::vector<std::string> names{"sensor", "grating", "flat", "identify", "test"};
  return names;
}

const std::vector<std::string>& showable_pattern_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = pattern_names();
    all.pop_back();
    return all;
  }();
  return names;
}

const std::vector<std::string>& norm_names() {
  static const std::vector<std::string> names{"rms", "unit"};
  return names;
}

const std::vector<std::string>& pixel_format_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const PixelFormatTraits& format : all_pixel_formats()) all.emplace_back(format.name);
    return all;
  }();
  return names;
}

const std::vector<std::string>& tracker_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const std::string_view name : all_tracker_names()) all.emplace_back(name);
    return all;
  }();
  return names;
}

const std::vector<std::string>& template_names() {
  static const std::vector<std::string> names{"model", "reference"};
  return names;
}

const std::vector<std::string>& operator_names() {
  static const std::vector<std::string> names{"slopes", "diffractive", "measured"};
  return names;
}

std::string_view pattern_name(HologramKind kind) {
  return pattern_names()[std::size_t(kind)];
}

std::string_view template_name(TemplateKind kind) {
  return template_names()[std::size_t(kind)];
}

std::string_view operator_name(OperatorKind kind) {
  return operator_names()[std::size_t(kind)];
}

}  // namespace ovws
