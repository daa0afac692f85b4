#include "core/spots/rendered_spot.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/spots/spot_sums.hpp"

namespace ovws {
namespace {

constexpr double kMaxOffCentre = 0.25;     // offset of a spot, fraction of a window's width
constexpr std::ptrdiff_t kDarkShare = 10;  // one of this many pixels around a spot is dark

}  // namespace

SpotWindow window_of(double lambda_d_px, double half_width, const LitPixels& lit) {
  constexpr double kMinBinnedPx = 10.0;
  SpotWindow window;
  window.lit = lit;
  window.bin = lit.plane.everything() && lambda_d_px >= kMinBinnedPx ? 2 : 1;
  window.side = std::max(kMinSide, int(std::ceil(2.0 * half_width * lambda_d_px / window.pitch())));
  return window;
}

double window_half_width(int modes, int subapertures_across) {
  return modes > optimal_mode_count(subapertures_across) ? 2.6 : 2.0;
}

SpotWindow moved_to(Vec2 place_px, SpotWindow window, int cols, int rows) {
  const int pixels = window.width_px(), step = window.plane_step();
  const auto first = [&](double at, int size, int plane) {
    const int most = (size - pixels - plane) / step;
    const double steps = std::round((at - 0.5 * (pixels - 1) - plane) / step);
    return plane + step * int(std::clamp(steps, 0.0, double(most)));
  };
  window.left = first(place_px.x, cols, step > 1 ? window.lit.plane.x : 0);
  window.top = first(place_px.y, rows, step > 1 ? window.lit.plane.y : 0);
  return window;
}

bool is_inside(const RenderedSpot& spot) {
  const double pixels = spot.window.width_px(), middle = 0.5 * (pixels - 1.0);
  const Vec2 off = spot.place_px - Vec2{spot.window.left + middle, spot.window.top + middle};
  return std::max(std::abs(off.x), std::abs(off.y)) <= kMaxOffCentre * pixels;
}

double dark_level(const Eigen::VectorXf& cells, const SpotWindow& window) {
  std::vector<float> lit;
  for (Eigen::Index c = 0; c < cells.size(); ++c) {
    if (window.is_lit(c)) lit.push_back(cells(c));
  }
  const auto dark = lit.begin() + std::ptrdiff_t(lit.size()) / kDarkShare;
  std::nth_element(lit.begin(), dark, lit.end());
  return double(*dark);
}

}  // namespace ovws
