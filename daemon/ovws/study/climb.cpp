#include "daemon/ovws/study/climb.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "daemon/ovws/study/searcher.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {
namespace {

constexpr double kGross = 0.5;   ///< lambda/d: a larger error counts as a wrong spot
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

/// The image of one amplitude step, scaled to kPeakE, and the factor that rescales it to equal
/// photons.
struct Step {
  Image<float> light_e;
  double to_equal_photons = 1.0;
};

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

/// The state of one climber: which realisations have ended.
struct ClimbState {
  Climber* climber;
  std::unique_ptr<Judge> judge;
  std::vector<bool> ended;

  void take(const Step& step, std::span<const Mode> modes, const ClimbSteps& steps,
            std::uint64_t seed) {
    Image<float> light_e = step.light_e;
    if (climber->light == Light::equal_photons) scale(light_e, step.to_equal_photons);
    for (std::size_t r = 0; r < ended.size(); ++r) {
      if (ended[r]) continue;
      Climb& reached = climber->climbs[r];
      const double read_noise_e = read_noise_of_snr(steps.snr);
      reached.limited_by =
          judge->judge(expose(light_e, read_noise_e, seed + 1000 * r), read_noise_e, modes);
      ended[r] = reached.limited_by != Limit::nothing;
      if (!ended[r]) reached.waves = std::abs(modes.front().waves);
    }
  }

  bool all_ended() const {
    return std::all_of(ended.begin(), ended.end(), [](bool one) { return one; });
  }

  void end(Limit limit) {
    for (std::size_t r = 0; r < ended.size(); ++r) {
      if (!ended[r]) climber->climbs[r].limited_by = limit;
    }
  }
};

Step step_of(const SensorModel& model, Image<float> light, std::span<const Mode> modes,
             double photons_scale) {
  const double to_peak = kPeakE / model.peak_of_spots(light, modes);
  scale(light, to_peak);
  return {std::move(light), photons_scale / to_peak};
}

}  // namespace

const char* name_of(Limit limit) {
  switch (limit) {
    case Limit::nothing:
      return "nothing";
    case Limit::sampling:
      return "sampling of the SLM";
    case Limit::leaving:
      return "spots leaving the image";
    case Limit::crossing:
      return "spots crossing";
    case Limit::wrong:
      return "wrong spots";
    case Limit::refused:
      break;
  }
  return "refused spots";
}

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

std::vector<Climber> climb(std::vector<Climber> climbers, int j, double sign,
                           const ClimbSteps& steps, std::uint64_t seed) {
  const Geometry geometry = default_bench();
  const auto vortex = model_of(geometry, 1), bright = model_of(geometry, 0);
  std::vector<ClimbState> states;
  for (Climber& climber : climbers) {
    climber.climbs.assign(std::size_t(steps.realisations), {});
    states.push_back({&climber,
                      std::make_unique<Judge>(geometry, climber.method,
                                              climber.method.charge == 0 ? bright : vortex),
                      std::vector<bool>(climber.climbs.size(), false)});
  }
  const int last = int(std::lround(steps.max_waves / steps.step_waves));
  for (int k = 1; k <= last; ++k, ++seed) {
    const double waves = k * steps.step_waves;
    const std::vector<Mode> modes{{j, sign * waves}};
    const auto ring = vortex->intensity(modes), spot = bright->intensity(modes);
    if (!ring || !spot) {
      for (ClimbState& state : states) state.end(Limit::sampling);
      break;
    }
    const double to_photons = kPeakE / vortex->peak_of_spots(*ring, modes);
    const Step ring_step = step_of(*vortex, *ring, modes, to_photons);
    const Step spot_step = step_of(*bright, *spot, modes, to_photons);
    bool all_ended = true;
    for (ClimbState& state : states) {
      if (state.all_ended()) continue;
      state.take(state.climber->method.charge == 0 ? spot_step : ring_step, modes, steps, seed);
      all_ended = all_ended && state.all_ended();
    }
    if (all_ended) break;
  }
  return climbers;
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

}  // namespace ovws::study
