#include "core/tracking/gaussian_window.hpp"

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

namespace ovws {
namespace {

// In units of w: a flat background cancels to a few 1e-4 of itself.
constexpr double kReach = 2.9;
constexpr double kFollow = 0.8;  // pixels
using Block = Eigen::Array<float, kPatchSlack, 1>;

}  // namespace

GaussianWindow::GaussianWindow(double radius_px)
    : radius_(radius_px),
      half_(int(std::ceil(kReach * radius_px))),
      blocks_((2 * half_ + kPatchSlack) / kPatchSlack),
      table_(std::size_t(half_) + 1) {
  for (int k = 0; k <= half_; ++k) table_[k] = float(std::exp(-(k * k) / (radius_ * radius_)));
}

int GaussianWindow::scratch_floats() const {
  return 5 * blocks_ * kPatchSlack;
}

// exp(-(k-f)^2/w^2) = exp(-k^2/w^2) exp(2f/w^2)^k exp(-f^2/w^2): three exponentials an axis.
void GaussianWindow::axis(double c, int first, float* g) const {
  const int mid = first + half_;
  const double f = c - mid;
  const double up = std::exp(2.0 * f / (radius_ * radius_));
  const double down = 1.0 / up;
  double right = std::exp(-f * f / (radius_ * radius_));
  double left = right;
  for (int k = 0; k <= half_; ++k, right *= up, left *= down) {
    g[half_ + k] = table_[k] * float(right);
    g[half_ - k] = table_[k] * float(left);
  }
}

GaussianWindow::Centre::Centre(Vec2 at) : x(int(std::lround(at.x))), y(int(std::lround(at.y))) {}

void GaussianWindow::Centre::follow(Vec2 at) {
  if (std::abs(at.x - x) > kFollow || std::abs(at.y - y) > kFollow) *this = Centre(at);
}

Moments GaussianWindow::at(const Patch& patch, Vec2 c, Centre centre,
                           std::span<float> scratch) const {
  const std::ptrdiff_t width = std::ptrdiff_t(blocks_) * kPatchSlack;
  const int count = 2 * half_ + 1;
  const int left = centre.x - half_, top = centre.y - half_;
  float* gx = scratch.data();
  float* gy = gx + width;
  float* columns = gy + width;  // three rows: sums over y of g I, g dy I, g dy^2 I
  axis(c.x, left, gx);
  axis(c.y, top, gy);

  const float* first = patch.at(left, top);
  for (std::ptrdiff_t b = 0; b < width; b += kPatchSlack) {
    Block s0 = Block::Zero(), s1 = Block::Zero(), s2 = Block::Zero();
    const float* p = first + b;
    for (int k = 0; k < count; ++k, p += patch.side) {
      const Block pixels = Eigen::Map<const Block>(p) * gy[k];
      const float dy = float(top + k - c.y);
      s0 += pixels;
      s1 += dy * pixels;
      s2 += (dy * dy) * pixels;
    }
    Eigen::Map<Block>(columns + b) = s0;
    Eigen::Map<Block>(columns + width + b) = s1;
    Eigen::Map<Block>(columns + 2 * width + b) = s2;
  }

  Moments m;
  double sum_gx = 0.0, sum_gy = 0.0;
  for (int k = 0; k < count; ++k) {
    const double dx = left + k - c.x, g = gx[k];
    const double a = g * columns[k], b = g * columns[width + k];
    m.one += a;
    m.x += dx * a;
    m.xx += dx * dx * a;
    m.y += b;
    m.xy += dx * b;
    m.yy += g * columns[2 * width + k];
    sum_gx += g;
    sum_gy += gy[k];
  }
  m.weight = sum_gx * sum_gy;
  return m;
}

}  // namespace ovws
