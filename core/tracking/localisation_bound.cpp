#include "core/tracking/localisation_bound.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ovws {
namespace {

template <int N>
double rms_of(const Eigen::Matrix<double, N, N>& information) {
  const Eigen::FullPivLU<Eigen::Matrix<double, N, N>> lu(information);
  if (!lu.isInvertible()) return std::numeric_limits<double>::infinity();
  const Eigen::Matrix<double, N, N> covariance = lu.inverse();
  return std::sqrt(0.5 * (covariance(0, 0) + covariance(1, 1)));
}

}  // namespace

LocalisationBound localisation_bound(const SpotShape& shape, Vec2 centre, int half_px,
                                     const SpotExposure& exposure) {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  const double cx = std::round(centre.x), cy = std::round(centre.y);
  for (int y = -half_px; y <= half_px; ++y) {
    for (int x = -half_px; x <= half_px; ++x) {
      const ShapeSample s = shape.at(Vec2{cx + x, cy + y} - centre);
      // Amplitude and background in units of the peak, so that the matrix is well scaled.
      const Eigen::Vector4d slope = exposure.peak_e * Eigen::Vector4d(s.dx, s.dy, s.value, 1.0);
      const double mean = exposure.peak_e * std::max(s.value, 0.0) + exposure.background_e;
      const double variance = mean + exposure.read_noise_e * exposure.read_noise_e;
      if (variance > 0.0) information += slope * slope.transpose() / variance;
    }
  }
  const Eigen::Matrix2d position = information.topLeftCorner<2, 2>();
  return {rms_of<4>(information), rms_of<2>(position)};
}

}  // namespace ovws
