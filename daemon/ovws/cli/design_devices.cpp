/// The devices of ovws design: the name of a model, or a size and a pitch.
#include <fmt/core.h>

#include <algorithm>
#include <regex>

#include "config/devices.hpp"
#include "core/base/number_text.hpp"
#include "daemon/ovws/cli/design.hpp"
#include "proto/limits.hpp"
#include "proto/names.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

struct Panel {
  int width = 0, height = 0;
  double pitch_um = 0.0;
};

/// "1920x1080@8".
std::optional<Panel> parse_panel(const std::string& text) {
  static const std::regex form(R"((\d{1,5})x(\d{1,5})@(\d{1,4}(?:\.\d{1,6})?))");
  std::smatch found;
  if (!std::regex_match(text, found, form)) return std::nullopt;
  return Panel{std::stoi(found[1]), std::stoi(found[2]), finite_number(found[3].str()).value()};
}

template <class Model>
const Model* find_model(const std::vector<Model>& models, const std::string& name) {
  const auto found = std::find_if(models.begin(), models.end(),
                                  [&name](const Model& model) { return model.name == name; });
  return found == models.end() ? nullptr : &*found;
}

template <class Model>
Error unknown_model(const char* option, const std::vector<Model>& models, const std::string& name) {
  std::vector<std::string> names;
  for (const Model& model : models) names.push_back(model.name);
  const auto near = nearest_name(name, names);
  return {Errc::invalid, option,
          "\"" + name + "\" is no known model" + (near ? " (did you mean " + *near + "?)" : "") +
              ": give WIDTHxHEIGHT@PITCH, e.g. 1920x1080@8, or see ovws design --list"};
}

/// Checks a size and a pitch against the ranges of the configuration.
Result<Panel> in_range(const char* option, Panel panel, limits::Integers size,
                       limits::Numbers pitch) {
  const auto inside = [&size](int px) { return px >= size.min && px <= size.max; };
  if (inside(panel.width) && inside(panel.height) && panel.pitch_um >= pitch.min &&
      panel.pitch_um <= pitch.max) {
    return panel;
  }
  return fail(Errc::invalid, option,
              fmt::format("must be {} to {} pixels of {:g} to {:g} um", size.min, size.max,
                          pitch.min, pitch.max));
}

Result<void> set_slm(design::Bench& bench, const std::string& text) {
  const auto& models = known_devices().slms;
  if (const SlmModel* model = find_model(models, text)) {
    bench.slm = model->geometry;
    bench.settle_ms = model->settle_ms;
    return {};
  }
  const auto panel = parse_panel(text);
  if (!panel) return fail(unknown_model("--slm", models, text));
  const auto valid = in_range("--slm", *panel, limits::kSlmSizePx, limits::kSlmPitchUm);
  if (!valid) return fail(valid.error());
  bench.slm = {valid->width, valid->height, valid->pitch_um};
  return {};
}

Result<void> set_camera(design::Bench& bench, const std::string& text) {
  const auto& models = known_devices().cameras;
  std::optional<Panel> panel = parse_panel(text);
  if (const CameraModel* model = find_model(models, text)) {
    panel = {model->width, model->height, model->pitch_um};
  }
  if (!panel) return fail(unknown_model("--camera", models, text));
  constexpr limits::Integers kSize{64, limits::kRoiSize.max};
  const auto valid = in_range("--camera", *panel, kSize, limits::kCameraPitchUm);
  if (!valid) return fail(valid.error());
  bench.sensor_width = valid->width;
  bench.sensor_height = valid->height;
  bench.camera_pitch_um = valid->pitch_um;
  return {};
}

}  // namespace

Result<design::Bench> bench_of(const DesignOptions& options) {
  design::Bench bench = options.bench;
  if (auto set = set_slm(bench, options.slm); !set) return fail(set.error());
  if (auto set = set_camera(bench, options.camera); !set) return fail(set.error());
  const auto& formats = kNames<PixelFormat>();
  bench.pixel_format = PixelFormat(std::find(formats.begin(), formats.end(), options.pixel_format) -
                                   formats.begin());
  return bench;
}

}  // namespace ovws::cli
