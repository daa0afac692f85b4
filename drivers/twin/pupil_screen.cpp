#include "drivers/twin/pupil_screen.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/twin/line_filter.hpp"

namespace ovws::twin {
namespace {

constexpr int kPointsAcross = 96;
constexpr int kLagrangeTaps = 6;
/// Interpolation points before the grid point at or below a position.
constexpr int kBefore = 2;

/// Interpolates between the columns of `points`. Position k is at column first + k step.
Eigen::MatrixXf between_columns(const Eigen::MatrixXf& points, double first, double step,
                                int count) {
  LineFilter filter;
  for (int k = 0; k < count; ++k) {
    const double at = first + k * step;
    const int first_tap =
        std::clamp(int(std::floor(at)) - kBefore, 0, int(points.cols()) - kLagrangeTaps);
    std::array<float, kLagrangeTaps> weights;
    for (int tap = 0; tap < kLagrangeTaps; ++tap) {
      double weight = 1.0;
      for (int other = 0; other < kLagrangeTaps; ++other) {
        if (other != tap) weight *= (at - first_tap - other) / (tap - other);
      }
      weights[std::size_t(tap)] = float(weight);
    }
    filter.append(first_tap, weights);
  }
  Eigen::MatrixXf columns(points.rows(), count);
  filter.apply({points.data(), points.rows(), int(points.rows())}, columns.data());
  return columns;
}

}  // namespace

PupilScreen::PupilScreen(const Turbulence& turbulence, std::int64_t t_ns, Vec2 centre_px,
                         double diameter_px, double margin_px)
    : step_px_(std::max(1, int(diameter_px / kPointsAcross))) {
  const double radius = diameter_px / 2;
  const double before = radius + margin_px + kBefore * step_px_;
  first_px_ = centre_px - Vec2{before, before};
  const int points = int((diameter_px + 2.0 * margin_px) / step_px_) + kLagrangeTaps + 1;
  points_ =
      turbulence.sample((1.0 / radius) * (first_px_ - centre_px), step_px_ / radius, points, t_ns);
}

Eigen::MatrixXf PupilScreen::waves(const Positions& x, const Positions& y) const {
  const Eigen::MatrixXf lines =
      between_columns(points_, (y.first_px - first_px_.y) / step_px_, y.step_px / step_px_, y.count)
          .transpose();
  return between_columns(lines, (x.first_px - first_px_.x) / step_px_, x.step_px / step_px_,
                         x.count);
}

}  // namespace ovws::twin
