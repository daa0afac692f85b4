#include "core/tracking/gaussian_window.hpp"

#include <cmath>
#include <cstddef>

#include "core/tracking/patch_kernels.hpp"

namespace ovws {
namespace {

// Half-width of the summed square, units of w: a flat background cancels to a few 1e-4 of itself.
constexpr double kHalfWidth = 2.9;
constexpr double kFollow = 0.8;  // hysteresis of the centre, pixels

}  // namespace

GaussianWindow::GaussianWindow(double radius_px)
    : radius_(radius_px),
      half_(int(std::ceil(kHalfWidth * radius_px))),
      table_(std::size_t(2 * half_ + kPatchBlock) / kPatchBlock * kPatchBlock, 0.0F) {
  for (int k = -half_; k <= half_; ++k) {
    table_[half_ + k] = float(std::exp(-(k * k) / (radius_ * radius_)));
  }
}

int GaussianWindow::scratch_floats() const {
  return 6 * int(table_.size());
}

// Factorised Gaussian: exp(-(k-f)^2/w^2) = exp(-k^2/w^2) exp(-f^2/w^2) exp(2f/w^2)^k needs only two
// exponentials per axis.
GaussianWindow::Axis GaussianWindow::axis(double c, int first, float* out) const {
  const double f = c - (first + half_), w2 = radius_ * radius_;
  const GaussianAxis from{table_.data(), int(table_.size()),
                          float(std::exp(-f * (f + 2.0 * half_) / w2)),
                          float(std::exp(2.0 * f / w2)), float(first - c)};
  float* const dg = out + from.padded;
  float* const ddg = dg + from.padded;
  const float sum = gaussian_axis(from, out, dg, ddg);
  return {{out, dg, ddg, 2 * half_ + 1, from.padded}, double(sum)};
}

GaussianWindow::Centre::Centre(Vec2 at) : x(int(std::lround(at.x))), y(int(std::lround(at.y))) {}

void GaussianWindow::Centre::follow(Vec2 at) {
  if (std::abs(at.x - x) > kFollow || std::abs(at.y - y) > kFollow) *this = Centre(at);
}

Moments GaussianWindow::at(const Patch& patch, Vec2 c, Centre centre,
                           std::span<float> scratch) const {
  const int left = centre.x - half_, top = centre.y - half_;
  const Axis across = axis(c.x, left, scratch.data());
  const Axis down = axis(c.y, top, scratch.data() + 3 * table_.size());
  const WindowSums sums =
      window_sums(patch.at(left, top), patch.side, across.weights, down.weights);
  return {sums.one, sums.x, sums.y, sums.xx, sums.xy, sums.yy, across.sum * down.sum};
}

}  // namespace ovws
