/// Study `masks`: which phase mask in every subaperture gives the smallest error of the modes, by
/// the Cramer-Rao bound and by the shapes of the spots.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/mode_bench.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

/// Masks of one shape, whose strength varies.
struct Shape {
  const char* name;
  int charge;
  std::optional<int> alternate;  ///< charge of every second subaperture
  int mode_j;                    ///< Zernike mode over the subaperture; kAxicon: a cone
  bool quick;                    ///< whether the quick form has it
};
constexpr int kAxicon = 0;
constexpr std::array<Shape, 13> kShapes{{
    {"bright, astigmatism", 0, std::nullopt, 3, true},
    {"bright, defocus", 0, std::nullopt, 4, true},
    {"bright, trefoil", 0, std::nullopt, 9, false},
    {"bright, coma", 0, std::nullopt, 8, false},
    {"bright, axicon", 0, std::nullopt, kAxicon, false},
    {"vortex, astigmatism", 1, std::nullopt, 3, true},
    {"vortex, defocus", 1, std::nullopt, 4, true},
    {"vortex, trefoil", 1, std::nullopt, 9, false},
    {"vortex, coma", 1, std::nullopt, 8, false},
    {"vortex, axicon", 1, std::nullopt, kAxicon, false},
    {"charges 1 and -1, astigmatism", 1, -1, 3, true},
    {"charges 0 and 1, astigmatism", 0, 1, 3, false},
    {"charge 2, astigmatism", 2, std::nullopt, 3, false},
}};

constexpr std::array<int, 3> kMaskModes{18, 27, 44};

/// A mask of one shape. `waves`: its RMS over the subaperture; 0: the charge alone.
Geometry masked_geometry(const Shape& shape, double waves) {
  Geometry geometry = default_bench();
  geometry.sensor.charge = shape.charge;
  geometry.sensor.alternate_charge = shape.alternate;
  if (waves == 0.0) return geometry;
  MaskConfig& mask = geometry.sensor.masks.emplace_back();
  if (shape.mode_j == kAxicon) {
    mask.axicon_waves = waves;
  } else {
    mask.modes = {{shape.mode_j, waves}};
  }
  return geometry;
}

/// Every shape at every strength. Shapes that begin with the same charges share strength 0.
std::vector<std::pair<Shape, double>> masks_of(bool quick) {
  const std::vector<double> strengths =
      quick ? std::vector<double>{0.0, 0.15, 0.3}
            : std::vector<double>{0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5};
  std::vector<std::pair<Shape, double>> masks;
  for (const Shape& shape : kShapes) {
    if (quick && !shape.quick) continue;
    for (const double waves : strengths) masks.emplace_back(shape, waves);
  }
  return masks;
}

/// The row with the smallest expected error by shapes.
nlohmann::json best_of(const Rows& rows) {
  const auto expected = [](const nlohmann::json& row) {
    const auto& value = row.at("shapes_expected_waves");
    return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
  };
  return *std::ranges::min_element(rows, {}, expected);
}

/// Figure for one number of modes at one light level: error by shapes against strength.
Figure mask_figure(int modes, Light light, const Rows& rows) {
  Figure figure{fmt::format("masks-{}{}", modes, suffix_of(light)),
                fmt::format("19 subapertures, {} modes, flat wavefront, {}", modes, name_of(light)),
                "strength of the mask (waves RMS over a subaperture)",
                "expected error without tilts (waves RMS)"};
  figure.log_y = true;
  for (const Shape& shape : kShapes) {
    figure.add(series_of({.name = shape.name}, rows_with(rows, {{"mask", shape.name}}),
                         "strength_waves", "shapes_expected_waves"));
  }
  return figure;
}

}  // namespace

Work masks(const Settings& settings) {
  const int images = settings.quick ? 4 : 20;
  const auto masks = masks_of(settings.quick);
  Rows conditions;
  for (const Light light : kLights) {
    for (const int modes : kMaskModes) {
      for (const auto& [shape, waves] : masks) {
        conditions.push_back(
            {{"mask", shape.name},
             {"charge", shape.charge},
             {"alternate_charge", shape.alternate ? nlohmann::json(*shape.alternate) : nullptr},
             {"strength_waves", waves},
             {"light", light},
             {"modes", modes}});
      }
    }
  }
  const auto measure = [=, seed = settings.seed](std::size_t k) {
    const std::size_t mask = k % masks.size(), level = k / masks.size();
    const auto& [shape, waves] = masks[mask];
    return measure_modes(masked_geometry(shape, waves), conditions[k].at("light"),
                         conditions[k].at("modes"), images, seed + 1000 * mask + level);
  };
  const auto draw = [](const Rows& rows, Findings& found) {
    for (const Light light : kLights) {
      for (const int modes : kMaskModes) {
        const Rows seen = rows_with(rows, {{"light", light}, {"modes", modes}});
        found.summary["best"].push_back(best_of(seen));
        found.figures.push_back(mask_figure(modes, light, seen));
      }
    }
  };
  return work_of({head_of_modes("masks"), conditions, measure, draw});
}

}  // namespace ovws::study
