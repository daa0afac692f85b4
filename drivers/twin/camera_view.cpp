#include "drivers/twin/camera_view.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"

namespace ovws::twin {
namespace {

constexpr int kTaps = CameraView::kTaps;
/// Kernel samples per grid step. Linear interpolation between samples errs by less than 1e-6.
constexpr int kKernelSteps = 512;
constexpr double kOversampling = 2.0;
/// Kaiser window's beta (Kaiser, "Nonrecursive digital filter design using the I0-sinh window
/// function", 1974) for a transition from 0.5 to 1.5 times the Nyquist frequency over 12 taps.
constexpr double kInterpolationBeta = 8.6;

double windowed_sinc(double t) {
  const double reach = t / (kTaps / 2);
  if (std::abs(reach) >= 1.0) return 0.0;
  return sinc(t) * std::cyl_bessel_i(0.0, kInterpolationBeta * std::sqrt(1.0 - reach * reach)) /
         std::cyl_bessel_i(0.0, kInterpolationBeta);
}

template <class Taps>
std::vector<Taps> make_kernel() {
  std::vector<Taps> kernel(kKernelSteps + 1);
  for (int step = 0; step <= kKernelSteps; ++step) {
    for (int k = 0; k < kTaps; ++k) {
      const double at = double(step) / kKernelSteps + (kTaps / 2 - 1) - k;
      kernel[std::size_t(step)][std::size_t(k)] = float(windowed_sinc(at));
    }
  }
  return kernel;
}

/// Interpolation along one axis: the first grid point to read, and the weights.
struct Interpolation {
  int first;
  Eigen::Array<float, kTaps, 1> weights;
};

template <class Taps>
Interpolation interpolate_at(double at, int period, const std::vector<Taps>& kernel) {
  at -= period * std::floor((at - kTaps / 2) / period);
  const double whole = std::floor(at);
  const double fine = (at - whole) * kKernelSteps;
  const int step = std::min(int(fine), kKernelSteps - 1);
  using Row = Eigen::Map<const Eigen::Array<float, kTaps, 1>>;
  const Row below(kernel[std::size_t(step)].data()), above(kernel[std::size_t(step) + 1].data());
  return {int(whole) - (kTaps / 2 - 1), below + float(fine - step) * (above - below)};
}

}  // namespace

CameraView::CameraView(const CameraMap& map, const SlmGeometry& slm, const Roi& window)
    : width_(window.width), height_(window.height), aligned_(map.axis_aligned()) {
  const CameraMap here = map.relative_to({double(window.x), double(window.y)});
  if (aligned_) {
    use_pixel_grid(here);
  } else {
    use_oversampled_grid(here, slm);
  }
}

void CameraView::use_pixel_grid(const CameraMap& map) {
  const bool transposed = map.of_x.x == 0.0;
  const bool from_right = map.of_x.x < 0.0 || map.of_y.x < 0.0;
  const bool from_below = map.of_x.y < 0.0 || map.of_y.y < 0.0;
  const Vec2 first{from_right ? width_ - 1.0 : 0.0, from_below ? height_ - 1.0 : 0.0};
  grid_ = {transposed ? height_ : width_, transposed ? width_ : height_, map.frequency(first),
           1.0 / map.scale};
  per_column_ = {map.of_x.x, map.of_y.x};
  per_row_ = {map.of_x.y, map.of_y.y};
  start_ = Vec2{} - (first.x * per_column_ + first.y * per_row_);
}

void CameraView::use_oversampled_grid(const CameraMap& map, const SlmGeometry& slm) {
  const Vec2 step{1.0 / (kOversampling * slm.width_px), 1.0 / (kOversampling * slm.height_px)};
  period_ = {int(kOversampling) * slm.width_px, int(kOversampling) * slm.height_px};
  const auto on_grid = [&](Vec2 px) {
    const Vec2 u = map.frequency(px);
    return Vec2{u.x / step.x, u.y / step.y};
  };
  const Vec2 origin = on_grid({0.0, 0.0});
  Vec2 low = origin, high = origin;
  for (const Vec2 corner :
       {Vec2{width_ - 1.0, 0.0}, Vec2{0.0, height_ - 1.0}, Vec2{width_ - 1.0, height_ - 1.0}}) {
    const Vec2 at = on_grid(corner);
    low = {std::min(low.x, at.x), std::min(low.y, at.y)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y)};
  }
  // One point more than the taps reach, so that rounding never wraps the first point to the end.
  const Vec2 margin{kTaps / 2 + 1.0, kTaps / 2 + 1.0};
  low = low - margin;
  const auto points = [](double span, int period) {
    return int(std::min(std::ceil(span), double(period))) + kTaps + 3;
  };
  grid_ = {points(high.x - low.x, period_[0]),
           points(high.y - low.y, period_[1]),
           {low.x * step.x, low.y * step.y},
           step.x,
           step.y};
  start_ = origin - low;
  per_column_ = on_grid({1.0, 0.0}) - origin;
  per_row_ = on_grid({0.0, 1.0}) - origin;
  kernel_ = make_kernel<Taps>();
}

void CameraView::copy(const Image<std::complex<float>>& far, int row,
                      std::complex<float>* out) const {
  const std::ptrdiff_t step = std::lround(per_column_.x + per_column_.y * far.width);
  const Vec2 at = start_ + double(row) * per_row_;
  const std::complex<float>* from = far.row(int(at.y)) + int(at.x);
  if (step == 1) {
    std::copy_n(from, width_, out);
    return;
  }
  for (int c = 0; c < width_; ++c) out[c] = from[c * step];
}

void CameraView::read(const Image<std::complex<float>>& far, int row,
                      std::complex<float>* out) const {
  if (aligned_) return copy(far, row, out);
  for (int c = 0; c < width_; ++c) {
    const Vec2 at = start_ + double(c) * per_column_ + double(row) * per_row_;
    const Interpolation x = interpolate_at(at.x, period_[0], kernel_),
                        y = interpolate_at(at.y, period_[1], kernel_);
    out[c] = tap_sum(far.row(y.first) + x.first, far.width, x.weights.data(), y.weights.data());
  }
}

}  // namespace ovws::twin
