#include "daemon/ovws/study/fitting.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/decompositions.hpp"
#include "core/spots/wavefront_fit.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {
namespace {

constexpr double kMaxStepWaves = 0.4;  // RMS; a longer step leaves the derivatives' valid range
constexpr int kSearchRenderings = 14;
constexpr double kHalfWidth = 3.0;  // lambda/d; wider windows would overlap
constexpr double kMinReadNoiseE = 0.5;

/// Electrons in each bin (square of camera pixels) of a window.
Eigen::VectorXd cells_of(const Image<float>& light_e, const SpotWindow& window) {
  Eigen::VectorXd cells = Eigen::VectorXd::Zero(window.cells());
  const PixelBox box = window.pixels();
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      cells(y / window.bin * window.side + x / window.bin) +=
          double(light_e.at(box.x + x, box.y + y));
    }
  }
  return cells;
}

}  // namespace

SpotRenderer renderer_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j,
                         const SpotRenderer::Options& options) {
  SensorConfig sensor = geometry.sensor;
  sensor.charge = charge;
  return value_of(SpotRenderer::make(sensor, geometry.slm, geometry.optics, kImagePx, kImagePx,
                                     modes_j, options));
}

PixelNoise noise_of(const Exposure& exposure, double read_noise_e) {
  constexpr double kRoundingDn2 = 1.0 / 12.0;
  const double read_noise_dn = read_noise_e * exposure.dn_per_e;
  return {read_noise_dn * read_noise_dn + kRoundingDn2, exposure.dn_per_e};
}

std::vector<double> fitted_waves(SpotRenderer& renderer, const Exposure& exposure,
                                 double read_noise_e, std::vector<double> start, int renderings) {
  const PixelNoise noise = noise_of(exposure, read_noise_e);
  std::vector<double> waves = std::move(start);
  const std::vector<double> none(waves.size(), kUnknown);
  if (std::isnan(waves.front())) return none;
  for (int k = 0; k < renderings; ++k) {
    const auto rendered = renderer.render(waves);
    const auto step = damped_step(fit_spots(exposure.view(), rendered, noise, kMaxSpotEstimates));
    if (!step) return none;
    const double damping = std::min(1.0, kMaxStepWaves / step->waves.norm());
    for (std::size_t j = 0; j < waves.size(); ++j) {
      waves[j] += damping * step->waves(Eigen::Index(j));
    }
  }
  return waves;
}

SpotRenderer bound_renderer_of(const Geometry& geometry, int charge,
                               const std::vector<int>& modes_j) {
  return renderer_of(geometry, charge, modes_j, {kHalfWidth});
}

Eigen::MatrixXd pixel_covariance(SpotRenderer& renderer, std::span<const Mode> modes,
                                 const Image<float>& light_e, double read_noise_e) {
  const std::vector<int>& modes_j = renderer.modes_j();
  const auto count = Eigen::Index(modes_j.size());
  const std::vector<RenderedSpot> spots = renderer.render(waves_of(modes, modes_j));
  const double read_noise = std::max(read_noise_e, kMinReadNoiseE);
  double measured = 0.0, rendered = 0.0;
  for (const RenderedSpot& spot : spots) {
    const Eigen::VectorXd light = spot.light.cast<double>();
    measured += light.dot(cells_of(light_e, spot.window));
    rendered += light.squaredNorm();
  }
  const double scale = measured / rendered;
  Eigen::MatrixXd fisher = Eigen::MatrixXd::Zero(count + 2, count + 2);
  for (const RenderedSpot& spot : spots) {
    const double pixels = spot.window.bin * spot.window.bin;
    Eigen::MatrixXd per_unknown(spot.light.size(), count + 2);
    per_unknown.leftCols(count) = scale * spot.per_wave.cast<double>();
    per_unknown.col(count) = spot.light.cast<double>();
    per_unknown.col(count + 1).setConstant(pixels);
    const Eigen::VectorXd variance =
        (cells_of(light_e, spot.window).array() + pixels * read_noise * read_noise).matrix();
    fisher += per_unknown.transpose() * variance.cwiseInverse().asDiagonal() * per_unknown;
  }
  const Cholesky factors(fisher);
  if (factors.reciprocal_condition() == 0.0) {
    return Eigen::MatrixXd::Constant(count, count, kUnknown);
  }
  return factors.inverse().topLeftCorner(count, count);
}

double wavefront_bound_rad2(const Geometry& geometry, int charge, std::span<const Mode> modes,
                            const Image<float>& light_e, double read_noise_e) {
  SpotRenderer renderer = bound_renderer_of(
      geometry, charge, first_modes_j(optimal_mode_count(geometry.sensor.subapertures_across)));
  const double trace = pixel_covariance(renderer, modes, light_e, read_noise_e).trace();
  return 4.0 * std::numbers::pi * std::numbers::pi * trace;
}

Searcher::Searcher(const Geometry& geometry, const Measurer& measurer)
    : measurer_(measurer),
      acquisition_({measurer.method().charge, measurer.lambda_d_px()}, measurer.reference_px(),
                   kImagePx, kImagePx),
      scratch_(measurer.tracker().make_scratch()) {
  if (measurer.method().tracking.tracker != TrackerKind::fit) return;
  model_.emplace(renderer_of(geometry, measurer.method().charge, measurer.modes_j()),
                 kMaxSpotEstimates);
}

std::vector<SpotFix> Searcher::find(const Exposure& exposure, double read_noise_e) {
  std::vector<SpotFix> fixes(std::size_t(measurer_.spots()));
  acquisition_.acquire(exposure.view(), measurer_.tracker(), scratch_, fixes);
  return model_ ? fitted(exposure, read_noise_e, fixes) : fixes;
}

std::vector<SpotFix> Searcher::fitted(const Exposure& exposure, double read_noise_e,
                                      const std::vector<SpotFix>& by_positions) {
  const PixelNoise noise = noise_of(exposure, read_noise_e);
  const std::vector<double> flat(measurer_.modes_j().size(), 0.0);
  std::vector<std::vector<double>> starts{measurer_.modes(by_positions), flat};
  if (std::isnan(starts.front().front())) starts.erase(starts.begin());
  const auto found = model_->templates(exposure.view(), noise, starts, {}, kSearchRenderings);
  if (found) return (*found)->measure(exposure.view()).spots;
  return std::vector<SpotFix>(by_positions.size());
}

}  // namespace ovws::study
