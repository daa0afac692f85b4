/// Study `range`: the largest amplitude of each mode with all spots found without history. The
/// amplitude grows in steps, and each image is acquired without history.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/searcher.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

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
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Climb, waves, limited_by)

struct ClimbSteps {
  double step_waves = 0.05;
  double max_waves = 2.0;  ///< RMS amplitude of the last step
  double snr = 10.0;       ///< peak SNR; sets the read noise by read_noise_of_snr
  int realisations = 1;
};

/// Ramp of one method at one light level: the amplitude that it reached in each realisation.
struct Climber {
  Method method;
  Light light;
  std::vector<Climb> climbs{};

  bool ended() const {
    return std::none_of(climbs.begin(), climbs.end(),
                        [](const Climb& one) { return one.limited_by == Limit::nothing; });
  }
};

/// Geometric limits of the ramp, at any light level: the amplitudes at which a spot leaves the
/// image or two spots cross. RMS waves, unsigned; NaN if above max_waves.
struct GeometricLimit {
  double leaving_waves, crossing_waves;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GeometricLimit, leaving_waves, crossing_waves)

/// Result for one mode and sign.
struct Reached {
  std::vector<std::vector<Climb>> climbs;  ///< of each climber
  GeometricLimit geometry{};
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Reached, climbs, geometry)

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

/// Both charges at both light levels, with the daemon's trackers. The vortex appears once, because
/// its image is the same at both light levels.
std::vector<Climber> all_climbers() {
  std::vector<Climber> all;
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    if (light == Light::equal_peak) {
      all.push_back({{"vortex, lg", 1, {TrackerKind::lg}}, light});
      all.push_back({{"vortex, fit", 1, {TrackerKind::fit}}, light});
    }
    all.push_back({{"Shack-Hartmann, thresholded", 0, {TrackerKind::thresholded}}, light});
    all.push_back({{"Shack-Hartmann, fit", 0, {TrackerKind::fit}}, light});
  }
  return all;
}

/// Ramps the amplitude of mode j with this sign for all climbers, and returns the climbs of each.
/// The same seed gives the same numbers.
std::vector<std::vector<Climb>> climb(int j, double sign, const ClimbSteps& steps,
                                      std::uint64_t seed) {
  const Geometry geometry = default_bench();
  const auto vortex = model_of(geometry, 1), bright = model_of(geometry, 0);
  const double read_noise_e = read_noise_of_snr(steps.snr);
  std::vector<Climber> climbers = all_climbers();
  std::vector<std::unique_ptr<Judge>> judges;
  for (Climber& climber : climbers) {
    climber.climbs.resize(std::size_t(steps.realisations));
    const auto& model = climber.method.charge == 0 ? bright : vortex;
    judges.push_back(std::make_unique<Judge>(geometry, climber.method, model));
  }
  const int last = int(std::lround(steps.max_waves / steps.step_waves));
  for (int k = 1; k <= last; ++k, ++seed) {
    const std::vector<Mode> modes{{j, sign * k * steps.step_waves}};
    const bool sampled = vortex->intensity(modes) && bright->intensity(modes);
    for (std::size_t c = 0; c < climbers.size(); ++c) {
      Climber& climber = climbers[c];
      if (climber.ended()) continue;
      Image<float> light_e;
      if (sampled) {
        light_e = electrons(climber.method.charge == 0 ? *bright : *vortex, *vortex, modes,
                            climber.light);
      }
      for (std::size_t r = 0; r < climber.climbs.size(); ++r) {
        Climb& reached = climber.climbs[r];
        if (reached.limited_by != Limit::nothing) continue;
        reached.limited_by = sampled
                                 ? judges[c]->judge(expose(light_e, read_noise_e, seed + 1000 * r),
                                                    read_noise_e, modes)
                                 : Limit::sampling;
        if (reached.limited_by == Limit::nothing) reached.waves = k * steps.step_waves;
      }
    }
  }
  std::vector<std::vector<Climb>> climbs;
  for (Climber& climber : climbers) climbs.push_back(std::move(climber.climbs));
  return climbs;
}

GeometricLimit geometric_limit(const Measurer& measurer, int j, double sign,
                               const ClimbSteps& steps) {
  constexpr double kPerWave = 100.0;
  const double margin_px = kMargin * measurer.lambda_d_px();
  GeometricLimit limit{kUnknown, kUnknown};
  for (int k = 0; k <= int(kPerWave * steps.max_waves); ++k) {
    const double waves = k / kPerWave;
    const std::vector<Mode> modes{{j, sign * waves}};
    const std::vector<Vec2> spots_px = measurer.predicted_px(modes);
    if (std::isnan(limit.leaving_waves) && leaves(spots_px, margin_px)) limit.leaving_waves = waves;
    if (std::isnan(limit.crossing_waves) && cross(spots_px, margin_px)) {
      limit.crossing_waves = waves;
    }
  }
  return limit;
}

/// Results for one mode and sign: the amplitude that each climber reached, and the geometric
/// limits.
struct Way {
  int j = 0;
  double sign = 1.0;
  std::vector<Climber> climbers{};
  GeometricLimit geometry{};
};

/// Whether the climber belongs to this light level. A vortex belongs to both levels, because its
/// image is the same at both.
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

nlohmann::json range_rows(const std::vector<Way>& ways) {
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
                        {"leaving_waves", way.geometry.leaving_waves},
                        {"crossing_waves", way.geometry.crossing_waves}});
      }
    }
  }
  return rows;
}

Series series_of(std::size_t c, const std::vector<Way>& ways) {
  Series series{ways.front().climbers[c].method.name, {}, {}, {}, Series::Style::points};
  for (const Way& way : ways) {
    const Mean waves = reached(way.climbers[c]);
    series.add(way.j, Mean{way.sign * waves.value, waves.standard_error, waves.count});
  }
  return series;
}

/// Series of a limit that geometry alone sets, independent of the method.
Series geometric_series(const char* name, double GeometricLimit::*limit,
                        const std::vector<Way>& ways) {
  Series series{name, {}, {}, {}, Series::Style::points, Series::kBlack};
  for (const Way& way : ways) {
    series.add(way.j, way.sign * way.geometry.*limit);
  }
  return series;
}

Figure range_figure(Light light, const std::vector<Way>& ways, const ClimbSteps& steps) {
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

Findings range_findings(std::vector<Way> ways, const ClimbSteps& steps,
                        const std::vector<Reached>& results) {
  for (std::size_t k = 0; k < ways.size(); ++k) {
    ways[k].climbers = all_climbers();
    for (std::size_t c = 0; c < ways[k].climbers.size(); ++c) {
      ways[k].climbers[c].climbs = results[k].climbs.at(c);
    }
    ways[k].geometry = results[k].geometry;
  }
  nlohmann::json summary{{"study", "range"},
                         {"unit", "waves, RMS-normalised"},
                         {"snr", steps.snr},
                         {"step_waves", steps.step_waves},
                         {"most_waves", steps.max_waves},
                         {"realisations", steps.realisations},
                         {"rows", range_rows(ways)}};
  return {std::move(summary),
          {range_figure(Light::equal_peak, ways, steps),
           range_figure(Light::equal_photons, ways, steps)}};
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
  return work_of(
      ways.size(),
      [=, seed = settings.seed](std::size_t k) {
        const Way& way = ways[k];
        return Reached{climb(way.j, way.sign, steps, seed + 1'000'000 * k),
                       geometric_limit(*geometric, way.j, way.sign, steps)};
      },
      [=](const std::vector<Reached>& results) { return range_findings(ways, steps, results); });
}

}  // namespace ovws::study
