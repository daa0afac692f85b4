/// Study `range`: the largest amplitude of each mode with all spots found without history.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "daemon/ovws/study/climb.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

/// Results for one mode and sign: the amplitude that each climber reached, and the geometric
/// limits.
struct Way {
  int j = 0;
  double sign = 1.0;
  std::vector<Climber> climbers{};
  GeometricLimit geometry{};
};

/// Whether the climber belongs to this light level. The vortex belongs to both: its image is the
/// same.
bool counts_at(const Climber& climber, Light light) {
  return climber.light == light || climber.method.charge != 0;
}

Mean reached(const Climber& climber) {
  std::vector<double> waves;
  for (const Climb& one : climber.climbs) waves.push_back(one.waves);
  return mean_of(waves);
}

/// The most frequent limit over the realisations.
Limit limited_by(const Climber& climber) {
  std::map<Limit, int> counts;
  for (const Climb& one : climber.climbs) ++counts[one.limited_by];
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

nlohmann::json rows_of(const std::vector<Way>& ways) {
  nlohmann::json rows = nlohmann::json::array();
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    for (const Way& way : ways) {
      for (const Climber& climber : way.climbers) {
        if (!counts_at(climber, light)) continue;
        const Mean waves = reached(climber);
        rows.push_back({{"light", name_of(light)},
                        {"method", climber.method.name},
                        {"j", way.j},
                        {"name", zernike_name(way.j)},
                        {"sign", way.sign > 0.0 ? 1 : -1},
                        {"waves", waves.value},
                        {"standard_error_waves", waves.standard_error},
                        {"unit_waves", waves.value * zernike_rms_factor(way.j)},
                        {"limited_by", name_of(limited_by(climber))},
                        {"leaving_waves", number_or_null(way.geometry.leaving_waves)},
                        {"crossing_waves", number_or_null(way.geometry.crossing_waves)}});
      }
    }
  }
  return rows;
}

Series series_of(std::size_t c, const std::vector<Way>& ways) {
  Series series{ways.front().climbers[c].method.name, {}, {}, {}, Series::Style::points};
  for (const Way& way : ways) {
    const Mean waves = reached(way.climbers[c]);
    series.x.push_back(way.j);
    series.y.push_back(way.sign * waves.value);
    series.error.push_back(waves.standard_error);
  }
  return series;
}

/// The points of a limit set by geometry, independent of the method.
Series geometric_series(const char* name, double GeometricLimit::*limit,
                        const std::vector<Way>& ways) {
  Series series{name, {}, {}, {}, Series::Style::points, Series::kBlack};
  for (const Way& way : ways) {
    series.x.push_back(way.j);
    series.y.push_back(way.sign * way.geometry.*limit);
  }
  return series;
}

Figure figure_of(Light light, const std::vector<Way>& ways, const ClimbSteps& steps) {
  Figure figure{light == Light::equal_peak ? "range" : "range-photons",
                fmt::format("Largest amplitude with all spots found without history, peak SNR {}, "
                            "{} (tried up to {})",
                            steps.snr, name_of(light), steps.max_waves),
                "OSA index j", "amplitude of either sign (waves RMS)"};
  figure.y_from = -steps.max_waves - 0.1;
  figure.y_to = steps.max_waves + 0.1;
  figure.x_step = 1.0;
  for (std::size_t c = 0; c < ways.front().climbers.size(); ++c) {
    if (!counts_at(ways.front().climbers[c], light)) continue;
    figure.series.push_back(series_of(c, ways));
    figure.series.back().shift_x = 0.16 * (double(figure.series.size()) - 2.5);
  }
  figure.series.push_back(
      geometric_series("a spot leaves the image", &GeometricLimit::leaving_waves, ways));
  figure.series.push_back(
      geometric_series("two spots meet", &GeometricLimit::crossing_waves, ways));
  return figure;
}

}  // namespace

Findings range(const Settings& settings) {
  const ClimbSteps steps =
      settings.quick ? ClimbSteps{0.15, 1.5, 10.0, 1} : ClimbSteps{0.1, 2.0, 10.0, 4};
  const std::vector<int> modes_j =
      settings.quick ? std::vector<int>{3, 4}
                     : std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  std::vector<Way> ways;
  for (const double sign : {1.0, -1.0}) {
    for (const int j : modes_j) ways.push_back({j, sign});
  }
  const Measurer geometric(default_bench(), {"", 1, {TrackerKind::lg}},
                           model_of(default_bench(), 1));
  parallel_for("range", ways.size(), settings.threads, [&](std::size_t k) {
    Way& way = ways[k];
    way.climbers = climb(all_climbers(), way.j, way.sign, steps, settings.seed + 1'000'000 * k);
    way.geometry = geometric_limit(geometric, way.j, way.sign, steps);
  });
  nlohmann::json summary{{"study", "range"},
                         {"unit", "waves, RMS-normalised"},
                         {"snr", steps.snr},
                         {"step_waves", steps.step_waves},
                         {"most_waves", steps.max_waves},
                         {"realisations", steps.realisations},
                         {"rows", rows_of(ways)}};
  return {
      std::move(summary),
      {figure_of(Light::equal_peak, ways, steps), figure_of(Light::equal_photons, ways, steps)}};
}

}  // namespace ovws::study
