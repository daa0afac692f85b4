/// Study `modes`: how many modes a lattice of spots determines, and how accurately: by the spots'
/// positions, by their shapes, and by the Cramer-Rao bound.
#include <spdlog/fmt/fmt.h>

#include <array>
#include <vector>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/mode_bench.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr std::array<int, 3> kCounts{19, 37, 61};  ///< of subapertures
constexpr std::array<int, 3> kCharges{1, 0, 2};
constexpr std::array<int, 4> kModeCounts{18, 27, 35, 44};

/// Bench with 19, 37 or 61 subapertures. The spots are as bright and as far apart (in lambda/d) as
/// on the default bench; a smaller magnification keeps them in the image.
Geometry unmasked_geometry(int subapertures, int charge) {
  Geometry geometry = default_bench();
  geometry.sensor.charge = charge;
  if (subapertures == 37) {
    geometry.sensor.subapertures_across = 7;
    geometry.sensor.spacing = 0.49;
    geometry.sensor.grooves = {300.0, 25.0};
    geometry.optics.magnification = 0.6;
  } else if (subapertures == 61) {
    geometry.sensor.subapertures_across = 9;
    geometry.sensor.spacing = 0.81;
    geometry.sensor.grooves = {340.0, 130.0};
    geometry.optics.magnification = 0.36;
  }
  return geometry;
}

Rows mode_conditions(const Settings& settings) {
  Rows all;
  for (const int subapertures : kCounts) {
    for (const int charge : kCharges) {
      if (settings.quick && (subapertures != 19 || charge == 2)) continue;
      for (const Light light : kLights) {
        for (const int modes : kModeCounts) {
          all.push_back({{"subapertures", subapertures},
                         {"charge", charge},
                         {"modes", modes},
                         {"light", light}});
        }
      }
    }
  }
  return all;
}

std::string sensor_name(int charge) {
  return charge == 0 ? "Shack-Hartmann" : charge == 1 ? "vortex" : "vortex of charge 2";
}

/// Figure of one lattice at one light level: errors by shapes and by positions for every charge,
/// and the Cramer-Rao bound.
Figure mode_figure(int subapertures, Light light, const Rows& rows) {
  Figure figure{fmt::format("modes-{}{}", subapertures, suffix_of(light)),
                fmt::format("{} subapertures, flat wavefront, {}", subapertures, name_of(light)),
                "modes measured", "error without tilts (waves RMS)"};
  figure.log_y = true;
  for (const int charge : kCharges) {
    const Rows of_charge = rows_with(rows, {{"charge", charge}});
    const std::string name = sensor_name(charge);
    figure.add(series_of({.name = name + ", shapes"}, of_charge, "modes", "shapes_waves",
                         "shapes_standard_error_waves"));
    figure.add(series_of({.name = name + ", positions"}, of_charge, "modes", "positions_waves",
                         "positions_standard_error_waves"));
    figure.add(series_of({.name = name + ", bound", .style = Series::Style::line}, of_charge,
                         "modes", "bound_waves"));
  }
  return figure;
}

}  // namespace

Work modes(const Settings& settings) {
  const int images = settings.quick ? 20 : 100;
  const Rows conditions = mode_conditions(settings);
  const auto measure = [=, seed = settings.seed](std::size_t k) {
    const auto& at = conditions[k];
    return measure_modes(unmasked_geometry(at.at("subapertures"), at.at("charge")), at.at("light"),
                         at.at("modes"), images, seed + 1000 * k);
  };
  const auto draw = [](const Rows& rows, Findings& found) {
    for (const int subapertures : kCounts) {
      for (const Light light : kLights) {
        const Rows seen = rows_with(rows, {{"subapertures", subapertures}, {"light", light}});
        if (!seen.empty()) found.figures.push_back(mode_figure(subapertures, light, seen));
      }
    }
  };
  return work_of({head_of_modes("modes"), conditions, measure, draw});
}

}  // namespace ovws::study
