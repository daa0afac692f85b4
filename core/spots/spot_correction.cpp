#include "core/spots/spot_correction.hpp"

#include <algorithm>
#include <cmath>

#include "core/spots/spot_renderer.hpp"

namespace ovws {
namespace {

// Distance from the calibration, waves RMS, at which the correction fades out: a straight line from
// there is worse than none at 0.2 wave.
constexpr double kReachWaves = 0.15;

/// Index of the binned pixel of `from` at which `to` begins, along one axis. Halves occur where
/// binned pixels begin at odd camera pixels: then two of them are averaged.
struct Begin {
  int first;
  float part;  ///< weight of the next one

  Begin(int to_px, int from_px, int pitch) {
    const double cells = double(to_px - from_px) / pitch;
    first = int(std::floor(cells));
    part = float(cells - first);
  }
};

/// Adds `weight` times the binned pixel of `from` that is `columns` to the right and `rows` below,
/// if there is one, to each lit binned pixel. `side`: of `from`.
void add_moved(const Eigen::MatrixXf& from, int side, int columns, int rows, float weight,
               const SpotWindow& window, Eigen::Ref<Eigen::MatrixXf> to) {
  const int left = std::max(0, -columns), right = std::min(window.side, side - columns);
  for (Eigen::Index k = 0; k < to.cols(); ++k) {
    for (int y = std::max(0, -rows); y < std::min(window.side, side - rows); ++y) {
      for (int x = left; x < right; ++x) {
        const Eigen::Index cell = Eigen::Index(y) * window.side + x;
        const Eigen::Index source = Eigen::Index(y + rows) * side + x + columns;
        if (window.is_lit(cell)) to(cell, k) += weight * from(source, k);
      }
    }
  }
}

/// Intensity of the pixels that the laser reaches.
Eigen::VectorXf lit_part(Eigen::VectorXf light, const SpotWindow& window) {
  for (Eigen::Index c = 0; c < light.size(); ++c) {
    if (!window.is_lit(c)) light(c) = 0.0F;
  }
  return light;
}

}  // namespace

std::optional<SpotCorrection> SpotCorrection::make(SpotRenderer& renderer,
                                                   const MeasuredShapes& measured,
                                                   std::span<const double> at_waves) {
  const std::vector<RenderedSpot>& spots = measured.spots;
  const bool like = spots.front().window.bin == renderer.window_size().bin &&
                    spots.front().window.lit == renderer.window_size().lit;
  if (!like || measured.poke_waves.size() != at_waves.size()) return std::nullopt;
  SpotCorrection made;
  made.at_waves_.assign(at_waves.begin(), at_waves.end());
  made.fixed_ = measured.fixed;
  const auto resting = renderer.light_in(spots, at_waves, measured.fixed);
  for (std::size_t i = 0; i < spots.size(); ++i) {
    Difference& one = made.differences_.emplace_back(Difference{spots[i].window, {}, {}});
    const Eigen::VectorXf rendered = lit_part(resting[i], one.window);
    const Eigen::VectorXf found = lit_part(spots[i].light, one.window);
    const float power = found.squaredNorm(), both = found.dot(rendered);
    if (!(power > 0.0F) || !(both > 0.0F)) continue;
    const float level = both / power;  // of every spot, because a fit finds its level anyway
    one.light = level * found - rendered;
    one.per_wave = level * spots[i].per_wave;
  }
  std::vector<double> waves(made.at_waves_);
  for (std::size_t k = 0; k < waves.size(); ++k) {
    for (const double poke : {measured.poke_waves[k], -measured.poke_waves[k]}) {
      waves[k] = at_waves[k] + poke;
      const auto poked = renderer.light_in(spots, waves, measured.fixed);
      for (std::size_t i = 0; i < poked.size(); ++i) {
        Difference& one = made.differences_[i];
        if (one.light.size() == 0) continue;
        one.per_wave.col(Eigen::Index(k)) -= float(0.5 / poke) * poked[i];
      }
    }
    waves[k] = at_waves[k];
  }
  return made;
}

/// RMS distance of a wavefront from that of the calibration, over all modes.
double SpotCorrection::distance_waves(std::span<const double> waves,
                                      std::span<const Mode> fixed) const {
  double squares = 0.0;
  for (std::size_t k = 0; k < waves.size(); ++k) squares += std::pow(waves[k] - at_waves_[k], 2);
  std::vector<Mode> others(fixed.begin(), fixed.end());
  for (const Mode& mode : fixed_) add_mode(others, {mode.j, -mode.waves});
  for (const Mode& mode : others) squares += mode.waves * mode.waves;
  return std::sqrt(squares);
}

void SpotCorrection::add_to(std::span<RenderedSpot> spots, std::span<const double> waves,
                            std::span<const Mode> fixed) const {
  Eigen::VectorXf step(Eigen::Index(waves.size()));
  for (std::size_t k = 0; k < waves.size(); ++k) {
    step(Eigen::Index(k)) = float(waves[k] - at_waves_[k]);
  }
  const auto share = float(std::exp(-std::pow(distance_waves(waves, fixed) / kReachWaves, 4.0)));
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Difference& one = differences_[i];
    if (one.light.size() == 0 || !(spots[i].light.maxCoeff() > 0.0F)) continue;
    const SpotWindow& window = spots[i].window;
    const Eigen::VectorXf light = one.light + one.per_wave * step;
    const Begin x(window.left, one.window.left, window.pitch());
    const Begin y(window.top, one.window.top, window.pitch());
    for (int corner = 0; corner < 4; ++corner) {
      const int columns = x.first + corner % 2, rows = y.first + corner / 2;
      const float weight = share * (corner % 2 == 1 ? x.part : 1.0F - x.part) *
                           (corner / 2 == 1 ? y.part : 1.0F - y.part);
      if (!(weight > 0.0F)) continue;
      const int side = one.window.side;
      add_moved(light, side, columns, rows, weight, window, spots[i].light);
      add_moved(one.per_wave, side, columns, rows, weight, window, spots[i].per_wave);
    }
  }
}

}  // namespace ovws
