#include "daemon/ovws/study/wavefront_bound.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/decompositions.hpp"
#include "daemon/ovws/study/fitting.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {
namespace {

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

SpotRenderer bound_renderer_of(const Geometry& geometry, int charge,
                               const std::vector<int>& modes_j) {
  return renderer_of(geometry, charge, modes_j, {kHalfWidth});
}

Eigen::MatrixXd pixel_covariance(SpotRenderer& renderer, std::span<const Mode> modes,
                                 const Image<float>& light_e, double read_noise_e) {
  const std::vector<int>& modes_j = renderer.modes_j();
  const auto count = Eigen::Index(modes_j.size());
  std::vector<double> waves(modes_j.size());
  for (const Mode& mode : modes) {
    const auto at = std::find(modes_j.begin(), modes_j.end(), mode.j);
    if (at != modes_j.end()) waves[std::size_t(at - modes_j.begin())] += mode.waves;
  }
  const std::vector<RenderedSpot> spots = renderer.render(waves);
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

}  // namespace ovws::study
