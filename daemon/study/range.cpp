/// The largest aberration that is found without history, mode by mode.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "daemon/study/climb.hpp"
#include "daemon/study/figure.hpp"
#include "daemon/study/parallel.hpp"
#include "daemon/study/statistics.hpp"
#include "daemon/study/studies.hpp"

namespace ovws::study {
namespace {

/// A mode and a sign: how far each climber came, and where geometry would have ended it.
struct Way {
  int j = 0;
  double sign = 1.0;
  std::vector<Climber> climbers{};
  GeometricLimit geometry{};
};

/// The vortex is climbed once for both lights: it has the same image at either.
bool counts_at(const Climber& climber, Light light) {
  return climber.light == light || climber.method.charge != 0;
}

Mean reached(const Climber& climber) {
  std::vector<double> waves;
  for (const Climb& one : climber.climbs) waves.push_back(one.waves);
  return mean_of(waves);
}

/// What ended most of the realisations.
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

/// A gap between the points of one sign and those of the other.
void end_of_sign(Series& series) {
  series.x.push_back(0.0);
  series.y.push_back(std::nan(""));
  series.error.push_back(0.0);
}

Figure figure_of(Light light, const std::vector<Way>& ways, const ClimbSteps& steps) {
  Figure figure{light == Light::equal_peak ? "range" : "range-photons",
                fmt::format("Largest mode found without history (all spots), read noise of peak "
                            "SNR {}, {}",
                            steps.snr, name_of(light)),
                "OSA index j", "largest amplitude of either sign (waves RMS)"};
  figure.y_from = -steps.most_waves - 0.1;
  figure.y_to = steps.most_waves + 0.1;
  for (std::size_t c = 0; c < ways.front().climbers.size(); ++c) {
    const Climber& first = ways.front().climbers[c];
    if (!counts_at(first, light)) continue;
    Series series{first.method.name, {}, {}, {}};
    series.shift_x = 0.12 * (double(figure.series.size()) - 1.5);
    for (const Way& way : ways) {
      if (!series.x.empty() && way.j < series.x.back()) end_of_sign(series);
      const Mean waves = reached(way.climbers[c]);
      series.x.push_back(way.j);
      series.y.push_back(way.sign * waves.value);
      series.error.push_back(waves.standard_error);
    }
    figure.series.push_back(std::move(series));
  }
  Series leaving{"a spot leaves the image", {}, {}, {}, Series::Style::line};
  Series crossing{"two spots meet", {}, {}, {}, Series::Style::line};
  for (const Way& way : ways) {
    for (Series* series : {&leaving, &crossing}) {
      if (!series->x.empty() && way.j < series->x.back()) {
        series->x.push_back(0.0);
        series->y.push_back(std::nan(""));
      }
      series->x.push_back(way.j);
    }
    leaving.y.push_back(way.sign * way.geometry.leaving_waves);
    crossing.y.push_back(way.sign * way.geometry.crossing_waves);
  }
  figure.series.push_back(std::move(leaving));
  figure.series.push_back(std::move(crossing));
  return figure;
}

}  // namespace

Findings range(const Settings& settings) {
  const ClimbSteps steps =
      settings.quick ? ClimbSteps{0.15, 1.5, 10.0, 1} : ClimbSteps{0.05, 2.0, 10.0, 5};
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
                         {"most_waves", steps.most_waves},
                         {"realisations", steps.realisations},
                         {"rows", rows_of(ways)}};
  return {
      std::move(summary),
      {figure_of(Light::equal_peak, ways, steps), figure_of(Light::equal_photons, ways, steps)}};
}

}  // namespace ovws::study
