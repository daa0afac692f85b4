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

struct ModeCase {
  int subapertures = 19;  ///< 19, 37 or 61
  int charge = 1;
  int modes = 18;  ///< number of modes: j = 1 to `modes`
  Budget budget = Budget::peak;
};

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

constexpr std::array<int, 4> kModeCounts{18, 27, 35, 44};

std::vector<ModeCase> cases_of(const Settings& settings) {
  std::vector<ModeCase> cases;
  for (const int subapertures : {19, 37, 61}) {
    for (const int charge : {1, 0, 2}) {
      if (settings.quick && (subapertures != 19 || charge == 2)) continue;
      for (const Budget budget : kBudgets) {
        for (const int modes : kModeCounts) cases.push_back({subapertures, charge, modes, budget});
      }
    }
  }
  return cases;
}

std::string sensor_name(int charge) {
  return charge == 0 ? "Shack-Hartmann" : charge == 1 ? "vortex" : "vortex of charge 2";
}

nlohmann::json mode_row(const ModeCase& one, const ModeErrors& errors) {
  return {{"subapertures", one.subapertures},
          {"charge", one.charge},
          {"modes", one.modes},
          {"light", name_of(one.budget)},
          {"bound_waves", errors.bound},
          {"shapes_waves", errors.shapes.value},
          {"shapes_standard_error_waves", errors.shapes.standard_error},
          {"shapes_expected_waves", errors.shapes_expected},
          {"positions_waves", errors.positions.value},
          {"positions_standard_error_waves", errors.positions.standard_error},
          {"positions_expected_waves", errors.positions_expected},
          {"images", errors.shapes.count}};
}

/// Figure of one lattice at one light level: errors by shapes and by positions for every charge,
/// and the Cramer-Rao bound.
Figure mode_figure(int subapertures, Budget budget, const std::vector<ModeCase>& cases,
                   const std::vector<ModeErrors>& errors) {
  Figure figure{fmt::format("modes-{}{}", subapertures, budget == Budget::peak ? "" : "-photons"),
                fmt::format("{} subapertures, flat wavefront, {}", subapertures, name_of(budget)),
                "modes measured", "error without tilts (waves RMS)"};
  figure.log_y = true;
  for (const int charge : {1, 0, 2}) {
    Series shapes{sensor_name(charge) + ", shapes", {}, {}, {}};
    Series positions{sensor_name(charge) + ", positions", {}, {}, {}};
    Series bound{sensor_name(charge) + ", bound", {}, {}, {}, Series::Style::line};
    for (std::size_t k = 0; k < cases.size(); ++k) {
      const ModeCase& one = cases[k];
      if (one.subapertures != subapertures || one.budget != budget || one.charge != charge)
        continue;
      const ModeErrors& found = errors[k];
      if (found.shapes.count > 0) shapes.add(one.modes, found.shapes);
      if (found.positions.count > 0) positions.add(one.modes, found.positions);
      bound.add(one.modes, found.bound);
    }
    for (Series* series : {&shapes, &positions, &bound}) {
      if (!series->x.empty()) figure.series.push_back(std::move(*series));
    }
  }
  return figure;
}

Findings modes_findings(const std::vector<ModeCase>& cases, const std::vector<ModeErrors>& errors,
                        bool quick) {
  Findings findings;
  findings.summary = {{"study", "modes"},
                      {"unit", "waves"},
                      {"peak_e", kPeakE},
                      {"photons_e", kPhotonsE},
                      {"read_noise_e", kModesReadNoiseE},
                      {"rows", nlohmann::json::array()}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    findings.summary["rows"].push_back(mode_row(cases[k], errors[k]));
  }
  for (const int subapertures : {19, 37, 61}) {
    if (quick && subapertures != 19) continue;
    for (const Budget budget : kBudgets) {
      findings.figures.push_back(mode_figure(subapertures, budget, cases, errors));
    }
  }
  return findings;
}

}  // namespace

Work modes(const Settings& settings) {
  const int images = settings.quick ? 20 : 100;
  const std::vector<ModeCase> cases = cases_of(settings);
  return work_of(
      cases.size(),
      [cases, images, seed = settings.seed](std::size_t k) {
        const ModeCase& one = cases[k];
        return measure_modes(unmasked_geometry(one.subapertures, one.charge), one.budget, one.modes,
                             images, seed + 1000 * k);
      },
      [cases, quick = settings.quick](const std::vector<ModeErrors>& errors) {
        return modes_findings(cases, errors, quick);
      });
}

}  // namespace ovws::study
