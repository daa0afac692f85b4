/// Study `modes`: how many modes a lattice of spots tells, and how exactly, against the bound.
#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <vector>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/mode_bench.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/sensor.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr std::array<int, 4> kModes{18, 27, 35, 44};
constexpr std::array<Budget, 2> kBudgets{Budget::peak, Budget::photons};

std::vector<ModeCase> cases_of(const Settings& settings) {
  std::vector<ModeCase> cases;
  for (const int subapertures : {19, 37, 61}) {
    for (const int charge : {1, 0, 2}) {
      if (settings.quick && (subapertures != 19 || charge == 2)) continue;
      for (const Budget budget : kBudgets) {
        for (const int modes : kModes) cases.push_back({subapertures, charge, modes, budget});
      }
    }
  }
  return cases;
}

std::string sensor_name(int charge) {
  return charge == 0 ? "Shack-Hartmann" : charge == 1 ? "vortex" : "vortex of charge 2";
}

nlohmann::json value_of(double value) {
  return std::isnan(value) ? nlohmann::json() : nlohmann::json(value);
}

nlohmann::json row_of(const ModeCase& one, const ModeErrors& errors) {
  return {{"subapertures", one.subapertures},
          {"charge", one.charge},
          {"modes", one.modes},
          {"light", name_of(one.budget)},
          {"bound_waves", value_of(errors.bound)},
          {"shapes_waves", value_of(errors.shapes.value)},
          {"shapes_standard_error_waves", errors.shapes.standard_error},
          {"shapes_expected_waves", value_of(errors.shapes_expected)},
          {"positions_waves", value_of(errors.positions.value)},
          {"positions_standard_error_waves", errors.positions.standard_error},
          {"positions_expected_waves", value_of(errors.positions_expected)},
          {"images", errors.shapes.count}};
}

void add_point(Series& series, int modes, const Mean& error) {
  if (std::isnan(error.value)) return;
  series.x.push_back(modes);
  series.y.push_back(error.value);
  series.error.push_back(error.standard_error);
}

/// One lattice in one light: every charge by shapes and by positions, and its bound.
Figure figure_of(int subapertures, Budget budget, const std::vector<ModeCase>& cases,
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
      add_point(shapes, one.modes, errors[k].shapes);
      add_point(positions, one.modes, errors[k].positions);
      bound.x.push_back(one.modes);
      bound.y.push_back(errors[k].bound);
    }
    for (Series* series : {&shapes, &positions, &bound}) {
      if (!series->x.empty()) figure.series.push_back(std::move(*series));
    }
  }
  return figure;
}

}  // namespace

Findings modes(const Settings& settings) {
  const int images = settings.quick ? 20 : 100;
  const std::vector<ModeCase> cases = cases_of(settings);
  std::vector<ModeErrors> errors(cases.size());
  parallel_for("modes", cases.size(), settings.threads, [&](std::size_t k) {
    errors[k] = measure_modes(cases[k], images, settings.seed + 1000 * k);
  });
  Findings findings;
  findings.summary = {{"study", "modes"},
                      {"unit", "waves"},
                      {"peak_e", kPeakE},
                      {"photons_e", kPhotonsE},
                      {"read_noise_e", kModesReadNoiseE},
                      {"rows", nlohmann::json::array()}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    findings.summary["rows"].push_back(row_of(cases[k], errors[k]));
  }
  for (const int subapertures : {19, 37, 61}) {
    if (settings.quick && subapertures != 19) continue;
    for (const Budget budget : kBudgets) {
      findings.figures.push_back(figure_of(subapertures, budget, cases, errors));
    }
  }
  return findings;
}

}  // namespace ovws::study
