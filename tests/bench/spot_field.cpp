#include "tests/bench/spot_field.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/optics/zernike.hpp"
#include "core/tracking/spot_shape.hpp"

namespace ovws::bench {
namespace {

constexpr double kLambdaDPerRegion = 12.5 / 64.0;
constexpr double kBlackDn = 100.0, kNoiseDn = 40.0;
constexpr double kOffPx = 3.0;

void put_spot(Image<std::uint16_t>& picture, const ModelShape& shape, Vec2 at, int half_px,
              std::mt19937& random) {
  std::normal_distribution<double> noise(0.0, kNoiseDn);
  const int x0 = int(at.x) - half_px, y0 = int(at.y) - half_px;
  for (int y = std::max(0, y0); y < std::min(picture.height, y0 + 2 * half_px); ++y) {
    for (int x = std::max(0, x0); x < std::min(picture.width, x0 + 2 * half_px); ++x) {
      const double light = shape.at({x - at.x, y - at.y}).value;
      const double dn = kBlackDn + kPeakDn * light + noise(random);
      picture.at(x, y) = std::uint16_t(std::clamp(dn, 0.0, 4095.0));
    }
  }
}

}  // namespace

SpotField::SpotField(int count, int region, int charge)
    : spots{charge, kLambdaDPerRegion * region}, region_px(region) {
  const int columns = int(std::ceil(std::sqrt(double(count))));
  const int rows = (count + columns - 1) / columns;
  // A border, so that no tracker's window is clipped.
  picture =
      Image<std::uint16_t>((columns + 1) * region, (rows + 1) * region, std::uint16_t(kBlackDn));
  const ModelShape shape(spots, 1.5 * region / spots.lambda_d_px);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> off(-kOffPx * region / 64.0, kOffPx * region / 64.0);
  for (int i = 0; i < count; ++i) {
    const Vec2 middle{double(region) * (i % columns + 1), double(region) * (i / columns + 1)};
    middles_px.push_back(middle);
    put_spot(picture, shape, middle + Vec2{off(random), off(random)}, region / 2, random);
  }
}

std::vector<RenderedSpot> rendered(const SpotField& field) {
  constexpr double kStepPx = 0.1;
  constexpr int kModes = 18;
  const double window_px = 4.0 * field.spots.lambda_d_px;
  const ModelShape shape(field.spots, 1.5 * field.region_px / field.spots.lambda_d_px);
  std::vector<RenderedSpot> spots;
  for (const Vec2 middle : field.middles_px) {
    RenderedSpot spot;
    spot.window.bin = field.spots.lambda_d_px >= 10.0 ? 2 : 1;  // as SpotRenderer
    spot.window.side = int(std::ceil(window_px / spot.window.bin));
    spot.window.left = int(middle.x) - spot.window.side * spot.window.bin / 2;
    spot.window.top = int(middle.y) - spot.window.side * spot.window.bin / 2;
    spot.place_px = middle;
    spot.light.resize(spot.window.cells());
    spot.per_px.resize(spot.window.cells(), 2);
    spot.per_wave.resize(spot.window.cells(), kModes);
    const double pixels = spot.window.bin * spot.window.bin;
    for (int c = 0; c < spot.window.cells(); ++c) {
      const Vec2 off{spot.window.left + (c % spot.window.side + 0.5) * spot.window.bin - middle.x,
                     spot.window.top + (c / spot.window.side + 0.5) * spot.window.bin - middle.y};
      const auto light = [&](double x, double y) {
        return float(pixels * shape.at({off.x - x, off.y - y}).value);
      };
      spot.light(c) = light(0.0, 0.0);
      spot.per_px(c, 0) = (light(kStepPx, 0.0) - spot.light(c)) / float(kStepPx);
      spot.per_px(c, 1) = (light(0.0, kStepPx) - spot.light(c)) / float(kStepPx);
      const Vec2 at = (1.0 / window_px) * off, pupil = (1.0 / field.picture.width) * middle;
      for (int k = 0; k < kModes; ++k) {
        const double across = zernike(k + 1, {2.0 * pupil.x - 1.0, 2.0 * pupil.y - 1.0});
        spot.per_wave(c, k) =
            float(across) * (spot.per_px(c, k % 2) + float(at.x * at.y) * spot.light(c));
      }
    }
    spots.push_back(std::move(spot));
  }
  return spots;
}

}  // namespace ovws::bench
