#include "tests/bench/spot_field.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/tracking/spot_shape.hpp"

namespace ovws::bench {
namespace {

constexpr double kLambdaDPerRegion = 12.5 / 64.0;
constexpr double kPeakDn = 2000.0, kBlackDn = 100.0, kNoiseDn = 40.0;
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

double centroid_mark(const SpotField& field) {
  constexpr int kThreshold = 300;
  double all = 0.0;
  for (const Vec2 middle : field.middles_px) {
    const int x0 = int(middle.x) - field.region_px / 2, y0 = int(middle.y) - field.region_px / 2;
    std::int64_t sum = 0, sum_x = 0, sum_y = 0;
    for (int y = 0; y < field.region_px; ++y) {
      const std::uint16_t* row = field.picture.row(y0 + y) + x0;
      std::int32_t line = 0, line_x = 0;
      for (int x = 0; x < field.region_px; ++x) {
        const std::int32_t above = row[x] > kThreshold ? row[x] - kThreshold : 0;
        line += above;
        line_x += above * x;
      }
      sum += line;
      sum_x += line_x;
      sum_y += std::int64_t(line) * y;
    }
    if (sum > 0) all += double(sum_x + sum_y) / double(sum);
  }
  return all;
}

}  // namespace ovws::bench
