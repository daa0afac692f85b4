#include "drivers/twin/pupil_screen.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/complex_product.hpp"
#include "core/optics/circle_columns.hpp"
#include "core/optics/phasors.hpp"

namespace ovws::twin {
namespace {

constexpr int kPointsAcross = 96;
/// Interpolation points before the grid point at or below a position.
constexpr int kBefore = 2;

}  // namespace

PupilScreen::PupilScreen(const Turbulence& turbulence, std::int64_t t_ns, Vec2 centre_px,
                         double diameter_px, double margin_px)
    : centre_px_(centre_px),
      diameter_px_(diameter_px),
      step_px_(std::max(1, int(diameter_px / kPointsAcross))),
      first_x_px_(int(std::floor(centre_px.x - diameter_px / 2 - margin_px))),
      first_y_px_(int(std::floor(centre_px.y - diameter_px / 2 - margin_px))) {
  const double radius = diameter_px / 2;
  // First grid point in pupil radii, per axis: the centre's pixel fraction may differ in x and y.
  const auto first = [&](int px, double centre) {
    return (px - kBefore * step_px_ - centre) / radius;
  };
  const int points = int((diameter_px + 2.0 * margin_px) / step_px_) + kTaps + 2;
  points_ = turbulence.sample({first(first_x_px_, centre_px.x), first(first_y_px_, centre_px.y)},
                              step_px_ / radius, points, t_ns);
  for (int between = 0; between < step_px_; ++between) {
    const double at = double(between) / step_px_ + kBefore;
    Taps taps;
    for (int k = 0; k < kTaps; ++k) {
      double weight = 1.0;
      for (int other = 0; other < kTaps; ++other) {
        if (other != k) weight *= (at - other) / (k - other);
      }
      taps[std::size_t(k)] = float(weight);
    }
    taps_.push_back(taps);
  }
}

void PupilScreen::modulate(int y, int width, std::complex<float>* row) const {
  const Columns pupil = columns_in_circle(centre_px_, diameter_px_, y, width);
  if (pupil.begin == pupil.end) return;
  modulate(y, pupil.begin, 1, pupil.end - pupil.begin, row + pupil.begin);
}

void PupilScreen::modulate(int y, int first_x_px, int step_px, int count,
                           std::complex<float>* values) const {
  const int below = y - first_y_px_;
  const Taps& across = taps_[std::size_t(below % step_px_)];
  const Eigen::Map<const Eigen::Matrix<float, kTaps, 1>> weights(across.data());
  const Eigen::VectorXf line = points_.middleCols(below / step_px_, kTaps) * weights;
  const std::vector<std::complex<float>>& phasors = unit_phasors();
  int right = first_x_px - first_x_px_;
  for (int i = 0; i < count; ++i, right += step_px) {
    const Taps& along = taps_[std::size_t(right % step_px_)];
    const float* from = line.data() + right / step_px_;
    float turns = 0.0F;
    for (std::size_t k = 0; k < kTaps; ++k) turns += along[k] * from[k];
    values[i] = product(values[i], phasors[phase16(turns)]);
  }
}

}  // namespace ovws::twin
