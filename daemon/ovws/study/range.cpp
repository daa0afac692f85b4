/// Study `range`: the largest amplitude of each mode with all spots found without history. The
/// amplitude grows in steps, and each image is acquired without history.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/fitting.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

using nlohmann::json;

/// What ended the ramp.
enum class Limit {
  nothing,   ///< the last step was reached
  sampling,  ///< the SLM cannot sample a larger amplitude
  leaving,   ///< a spot is within lambda/d of the image's edge
  crossing,  ///< two spots are within lambda/d of each other
  wrong,     ///< a spot was found at a wrong place
  refused    ///< an existing spot was not found
};
const char* name_of(Limit limit) {
  constexpr const char* kNames[]{"nothing",        "sampling of the SLM", "spots leaving the image",
                                 "spots crossing", "wrong spots",         "refused spots"};
  return kNames[int(limit)];
}

struct Climb {
  double waves = 0.0;  ///< RMS, unsigned: up to this amplitude every spot was found at its place
  Limit limited_by = Limit::nothing;  ///< `nothing`: the ramp has not ended
};

struct ClimbSteps {
  double step_waves = 0.05;
  double max_waves = 2.0;  ///< RMS amplitude of the last step
  double snr = 10.0;       ///< peak SNR; sets the read noise by read_noise_of_snr
  int realisations = 1;
};

/// Method at a light level whose amplitude is raised.
struct Climber {
  Method method;
  Light light;
  /// A vortex counts at both light levels, because its image is the same at both.
  bool counts_at(Light level) const { return light == level || method.charge != 0; }
};

constexpr double kMargin = 1.0;  ///< lambda/d: the size of a vortex ring

bool leaves(const std::vector<Vec2>& spots_px, double margin_px) {
  return std::any_of(spots_px.begin(), spots_px.end(), [&](Vec2 at) {
    const double most = kImagePx - 1 - margin_px;
    return std::min(at.x, at.y) < margin_px || std::max(at.x, at.y) > most;
  });
}

bool cross(const std::vector<Vec2>& spots_px, double apart_px) {
  for (std::size_t i = 0; i < spots_px.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (norm(spots_px[i] - spots_px[k]) < apart_px) return true;
    }
  }
  return false;
}

/// Acquires spots with one method and compares them with the positions predicted by the slopes.
class Judge {
 public:
  Judge(const Geometry& geometry, const Method& method, std::shared_ptr<SensorModel> model)
      : measurer_(geometry, method, std::move(model)), searcher_(geometry, measurer_) {}

  /// Classifies the failure of an acquisition; Limit::nothing: every spot was found at its place.
  Limit judge(const Exposure& exposure, double read_noise_e, std::span<const Mode> modes) {
    const std::vector<Vec2> truth = measurer_.predicted_px(modes);
    const std::vector<SpotFix> fixes = searcher_.find(exposure, read_noise_e);
    bool refused = false, wrong = false;
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      const Vec2 off = Vec2{fixes[i].x, fixes[i].y} - truth[i];
      refused = refused || !fixes[i].found();
      wrong = wrong || (fixes[i].found() && norm(off) > kGross * measurer_.lambda_d_px());
    }
    if (!refused && !wrong) return Limit::nothing;
    const double margin_px = kMargin * measurer_.lambda_d_px();
    if (leaves(truth, margin_px)) return Limit::leaving;
    if (cross(truth, margin_px)) return Limit::crossing;
    return wrong ? Limit::wrong : Limit::refused;
  }

 private:
  Measurer measurer_;
  Searcher searcher_;
};

/// Both charges at both light levels, with the daemon's trackers.
std::vector<Climber> all_climbers() {
  std::vector<Climber> all;
  for (const Light light : kLights) {
    if (light == Light::equal_peak) {
      all.push_back({{"vortex, lg", 1, {TrackerKind::lg}}, light});
      all.push_back({{"vortex, fit", 1, {TrackerKind::fit}}, light});
    }
    all.push_back({{"Shack-Hartmann, thresholded", 0, {TrackerKind::thresholded}}, light});
    all.push_back({{"Shack-Hartmann, fit", 0, {TrackerKind::fit}}, light});
  }
  return all;
}

/// The amplitude that the realisations of a climber reached, and what ended most of them, as
/// columns of a table.
json columns_of(const std::vector<Climb>& climbs) {
  std::vector<double> waves;
  std::map<Limit, int> counts;
  for (const Climb& one : climbs) {
    waves.push_back(one.waves);
    ++counts[one.limited_by];
  }
  const auto most =
      std::ranges::max_element(counts, {}, [](const auto& one) { return one.second; });
  const Mean mean = mean_of(waves);
  return {{"waves", mean.value},
          {"standard_error_waves", mean.standard_error},
          {"limited_by", most->first}};
}

/// Ramps the amplitude of mode j with this sign for all climbers, and returns the columns of each.
/// The same seed gives the same numbers.
json climb(int j, double sign, const ClimbSteps& steps, std::uint64_t seed) {
  const Geometry geometry = default_bench();
  const SensorPair sensors(geometry);
  const double read_noise_e = read_noise_of_snr(steps.snr);
  const std::vector<Climber> climbers = all_climbers();
  std::vector<std::unique_ptr<Judge>> judges;
  std::vector<std::vector<Climb>> climbs(climbers.size(),
                                         std::vector<Climb>(std::size_t(steps.realisations)));
  for (const Climber& climber : climbers) {
    judges.push_back(
        std::make_unique<Judge>(geometry, climber.method, sensors.of(climber.method.charge)));
  }
  const auto goes_on = [](const Climb& one) { return one.limited_by == Limit::nothing; };
  const int last = int(std::lround(steps.max_waves / steps.step_waves));
  for (int k = 1; k <= last; ++k, ++seed) {
    const std::vector<Mode> modes{{j, sign * k * steps.step_waves}};
    const bool sampled = sensors.of(1)->intensity(modes) && sensors.of(0)->intensity(modes);
    for (std::size_t c = 0; c < climbers.size(); ++c) {
      if (std::ranges::none_of(climbs[c], goes_on)) continue;
      Image<float> light_e;
      if (sampled) {
        light_e = sensors.electrons(climbers[c].method.charge, modes, climbers[c].light);
      }
      for (std::size_t r = 0; r < climbs[c].size(); ++r) {
        Climb& reached = climbs[c][r];
        if (!goes_on(reached)) continue;
        reached.limited_by = sampled
                                 ? judges[c]->judge(expose(light_e, read_noise_e, seed + 1000 * r),
                                                    read_noise_e, modes)
                                 : Limit::sampling;
        if (goes_on(reached)) reached.waves = k * steps.step_waves;
      }
    }
  }
  json columns = json::array();
  for (const auto& one : climbs) columns.push_back(columns_of(one));
  return columns;
}

/// Geometric limits of the ramp, at any light level: the amplitudes at which a spot leaves the
/// image or two spots cross. RMS waves, unsigned; NaN if above max_waves.
json geometric_limits(const Measurer& measurer, int j, double sign, const ClimbSteps& steps) {
  constexpr double kPerWave = 100.0;
  const double margin_px = kMargin * measurer.lambda_d_px();
  double leaving = kUnknown, crossing = kUnknown;
  for (int k = 0; k <= int(kPerWave * steps.max_waves); ++k) {
    const double waves = k / kPerWave;
    const std::vector<Mode> modes{{j, sign * waves}};
    const std::vector<Vec2> spots_px = measurer.predicted_px(modes);
    if (std::isnan(leaving) && leaves(spots_px, margin_px)) leaving = waves;
    if (std::isnan(crossing) && cross(spots_px, margin_px)) crossing = waves;
  }
  return {{"leaving_waves", leaving}, {"crossing_waves", crossing}};
}

/// A mode, and the sign of its amplitude.
struct Way {
  int j = 0;
  double sign = 1.0;
};

/// `results`: of each way, {"climbers", "limits"}.
Rows range_rows(const std::vector<Way>& ways, const std::vector<json>& results) {
  const std::vector<Climber> climbers = all_climbers();
  Rows rows;
  for (const Light light : kLights) {
    for (std::size_t k = 0; k < ways.size(); ++k) {
      for (std::size_t c = 0; c < climbers.size(); ++c) {
        if (!climbers[c].counts_at(light)) continue;
        json& row = rows.emplace_back(results[k].at("climbers").at(c));
        row.update(results[k].at("limits"));
        row.update({{"light", light},
                    {"method", climbers[c].method.name},
                    {"j", ways[k].j},
                    {"name", zernike_name(ways[k].j)},
                    {"sign", ways[k].sign > 0.0 ? 1 : -1},
                    {"unit_waves", row.at("waves").get<double>() * zernike_rms_factor(ways[k].j)},
                    {"limited_by", name_of(row.at("limited_by").get<Limit>())}});
      }
    }
  }
  return rows;
}

/// The column `key` as amplitudes of either sign, by the modes of the rows.
Series amplitudes(const std::string& name, Rows rows, const char* key, const char* error) {
  for (json& row : rows) row[key] = row.at("sign").get<double>() * row.at(key).get<double>();
  return series_of({.name = name, .style = Series::Style::points}, rows, "j", key, error);
}

Figure range_figure(Light light, const Rows& rows, const ClimbSteps& steps) {
  Figure figure{std::string("range") + suffix_of(light),
                fmt::format("Largest amplitude with all spots found without history, peak SNR {}, "
                            "{} (tried up to {})",
                            steps.snr, name_of(light), steps.max_waves),
                "OSA index j", "amplitude of either sign (waves RMS)"};
  figure.y_from = -steps.max_waves - 0.1;
  figure.y_to = steps.max_waves + 0.1;
  figure.x_step = 1.0;
  Rows of_method;
  for (const Climber& climber : all_climbers()) {
    if (!climber.counts_at(light)) continue;
    of_method = rows_with(rows, {{"light", light}, {"method", climber.method.name}});
    figure.add(amplitudes(climber.method.name, of_method, "waves", "standard_error_waves"));
    figure.series.back().shift_x = 0.16 * (double(figure.series.size()) - 2.5);
  }
  for (const auto& [name, key] : {std::pair{"a spot leaves the image", "leaving_waves"},
                                  {"two spots meet", "crossing_waves"}}) {
    figure.add(amplitudes(name, of_method, key, nullptr));
    figure.series.back().colour = Series::kBlack;
  }
  return figure;
}

}  // namespace

Work range(const Settings& settings) {
  const ClimbSteps steps =
      settings.quick ? ClimbSteps{0.15, 1.5, 10.0, 1} : ClimbSteps{0.1, 2.0, 10.0, 4};
  const std::vector<int> modes_j =
      settings.quick ? std::vector<int>{3, 4}
                     : std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14};
  std::vector<Way> ways;
  for (const double sign : {1.0, -1.0}) {
    for (const int j : modes_j) ways.push_back({j, sign});
  }
  const auto geometric = std::make_shared<const Measurer>(
      default_bench(), Method{"", 1, {TrackerKind::lg}}, model_of(default_bench(), 1));
  const auto measure = [=, seed = settings.seed](std::size_t k) -> json {
    const auto& [j, sign] = ways[k];
    return {{"climbers", climb(j, sign, steps, seed + 1'000'000 * k)},
            {"limits", geometric_limits(*geometric, j, sign, steps)}};
  };
  const auto find = [=](const std::vector<json>& results) {
    const Rows rows = range_rows(ways, results);
    return Findings{{{"study", "range"},
                     {"unit", "waves, RMS-normalised"},
                     {"snr", steps.snr},
                     {"step_waves", steps.step_waves},
                     {"most_waves", steps.max_waves},
                     {"realisations", steps.realisations},
                     {"rows", rows}},
                    {range_figure(Light::equal_peak, rows, steps),
                     range_figure(Light::equal_photons, rows, steps)}};
  };
  return {ways.size(), measure, find};
}

}  // namespace ovws::study
