#include "core/tracking/lg_contour.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/tracking/gaussian_window.hpp"

namespace ovws {
namespace {

constexpr int kSubdivision = 16;

/// Psi sampled on a square grid of positions.
struct PsiGrid {
  Vec2 origin;
  double step = 1.0;
  int count = 0;  ///< samples per side
  std::vector<std::complex<double>> values;

  const std::complex<double>& at(int i, int j) const { return values[std::size_t(j) * count + i]; }
  Vec2 position(Vec2 cell) const { return origin + step * cell; }
};

template <class Psi>
PsiGrid sample(Vec2 origin, double step, int count, Psi psi) {
  PsiGrid grid{origin, step, count, {}};
  grid.values.reserve(std::size_t(count) * count);
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) grid.values.push_back(psi(grid.position({1.0 * i, 1.0 * j})));
  }
  return grid;
}

struct Segment {
  Vec2 a, b;
};

/// Marching squares: the zero contour inside one grid square with the corner values v00, v10, v01,
/// v11 (x first), as none, one or two segments in units of the grid step.
std::vector<Segment> zero_contour(double v00, double v10, double v01, double v11) {
  const auto cut = [](double p, double q) { return p / (p - q); };
  const bool s00 = v00 > 0.0, s10 = v10 > 0.0, s01 = v01 > 0.0, s11 = v11 > 0.0;
  std::vector<Vec2> cuts;  // on the top, right, bottom, left edge, in this order
  if (s00 != s10) cuts.push_back({cut(v00, v10), 0.0});
  if (s10 != s11) cuts.push_back({1.0, cut(v10, v11)});
  if (s01 != s11) cuts.push_back({cut(v01, v11), 1.0});
  if (s00 != s01) cuts.push_back({0.0, cut(v00, v01)});
  if (cuts.size() == 2) return {{cuts[0], cuts[1]}};
  if (cuts.size() != 4) return {};
  // Ambiguous case: the sign at the centre decides which corners the two contours cut off.
  const bool centre = v00 + v10 + v01 + v11 > 0.0;
  if (centre == s00) return {{cuts[0], cuts[1]}, {cuts[2], cuts[3]}};
  return {{cuts[3], cuts[0]}, {cuts[1], cuts[2]}};
}

std::optional<Vec2> crossing(const Segment& p, const Segment& q) {
  const Vec2 u = p.b - p.a, v = q.b - q.a, d = q.a - p.a;
  const double det = u.x * v.y - u.y * v.x;
  if (det == 0.0) return std::nullopt;
  const double s = (d.x * v.y - d.y * v.x) / det, t = (d.x * u.y - d.y * u.x) / det;
  if (s < 0.0 || s > 1.0 || t < 0.0 || t > 1.0) return std::nullopt;
  return p.a + s * u;
}

struct Zero {
  Vec2 at;
  int index = 0;  ///< sign of the Jacobian of (Re, Im) of Psi
};

std::vector<Zero> zeros_of(const PsiGrid& grid) {
  std::vector<Zero> zeros;
  for (int j = 0; j + 1 < grid.count; ++j) {
    for (int i = 0; i + 1 < grid.count; ++i) {
      const auto v00 = grid.at(i, j), v10 = grid.at(i + 1, j);
      const auto v01 = grid.at(i, j + 1), v11 = grid.at(i + 1, j + 1);
      const auto dx = v10 + v11 - v00 - v01, dy = v01 + v11 - v00 - v10;
      const int index = dx.real() * dy.imag() - dx.imag() * dy.real() > 0.0 ? 1 : -1;
      for (const auto& re : zero_contour(v00.real(), v10.real(), v01.real(), v11.real())) {
        for (const auto& im : zero_contour(v00.imag(), v10.imag(), v01.imag(), v11.imag())) {
          const auto at = crossing(re, im);
          if (at) zeros.push_back({grid.position(*at + Vec2{1.0 * i, 1.0 * j}), index});
        }
      }
    }
  }
  return zeros;
}

double recorded_intensity(const Patch& patch, Vec2 at) {
  const int x = int(std::floor(at.x)), y = int(std::floor(at.y));
  const double fx = at.x - x, fy = at.y - y;
  const float* p = patch.at(x, y);
  const float* q = patch.at(x, y + 1);
  return (1 - fy) * ((1 - fx) * double(p[0]) + fx * double(p[1])) +
         fy * ((1 - fx) * double(q[0]) + fx * double(q[1]));
}

}  // namespace

LgContourTracker::LgContourTracker(const SpotModel& spots, double kernel_radius_px)
    : PatchTracker(spots, GaussianWindow(kernel_radius_px).half_px() + 1, 0),
      w_(kernel_radius_px),
      half_(GaussianWindow(kernel_radius_px).half_px()) {}

std::complex<double> LgContourTracker::psi(const Patch& patch, Vec2 at) const {
  const double sigma = 1.0 / (std::numbers::pi * w_);
  const double k = std::numbers::pi * std::numbers::pi * sigma * sigma;  // 1/w^2
  const int cx = int(std::lround(at.x)), cy = int(std::lround(at.y));
  std::vector<double> gx(std::size_t(2 * half_) + 1);
  for (int i = -half_; i <= half_; ++i) gx[half_ + i] = std::exp(-k * std::pow(at.x - cx - i, 2));
  std::complex<double> sum = 0.0;
  for (int y = cy - half_; y <= cy + half_; ++y) {
    const double gy = std::exp(-k * std::pow(at.y - y, 2));
    const float* row = patch.at(cx - half_, y);
    for (int i = -half_; i <= half_; ++i) {
      // Convolution: the kernel's argument is the position minus the pixel.
      const std::complex<double> r(at.x - cx - i, at.y - y);
      sum += double(row[half_ + i]) * gx[half_ + i] * gy * r;
    }
  }
  return std::complex<double>(0.0, k * sigma * sigma) * sum;
}

std::optional<PatchTracker::Found> LgContourTracker::find(Patch& patch, Vec2 start,
                                                          TrackScratch&) const {
  const auto psi_at = [&](Vec2 at) { return psi(patch, at); };
  const int reach = int(std::ceil(capture_px()));
  const Vec2 corner{std::round(start.x) - reach, std::round(start.y) - reach};
  std::optional<Found> best;
  double best_intensity = 0.0;
  for (const Zero& coarse : zeros_of(sample(corner, 1.0, 2 * reach + 1, psi_at))) {
    if (norm(coarse.at - start) > capture_px()) continue;
    const auto fine =
        zeros_of(sample(coarse.at - Vec2{0.5, 0.5}, 1.0 / kSubdivision, kSubdivision + 1, psi_at));
    for (const Zero& zero : fine) {
      if (zero.index < 0 || norm(zero.at - start) > capture_px()) continue;
      const SpotCheck::Verdict verdict = check().look(patch, zero.at);
      const double intensity = recorded_intensity(patch, zero.at);
      const bool better =
          spots().charge != 0 ? intensity < best_intensity : intensity > best_intensity;
      if (!verdict.passed || (best && !better)) continue;
      best = Found{zero.at, verdict};
      best_intensity = intensity;
    }
  }
  return best;
}

}  // namespace ovws
