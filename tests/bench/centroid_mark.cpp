/// Built for this machine, see CMakeLists.txt.
#include "tests/bench/spot_field.hpp"

namespace ovws::bench {

double centroid_mark(const SpotField& field) {
  constexpr std::int32_t kThreshold = 300;
  double all = 0.0;
  for (const Vec2 middle : field.middles_px) {
    const int x0 = int(middle.x) - field.region_px / 2, y0 = int(middle.y) - field.region_px / 2;
    float sum = 0.0F, sum_x = 0.0F, sum_y = 0.0F;
    for (int y = 0; y < field.region_px; ++y) {
      const std::uint16_t* row = field.picture.row(y0 + y) + x0;
      std::int32_t line = 0, line_x = 0;
      for (int x = 0; x < field.region_px; ++x) {
        const std::int32_t above = row[x] > kThreshold ? row[x] - kThreshold : 0;
        line += above;
        line_x += above * x;
      }
      sum += float(line);
      sum_x += float(line_x);
      sum_y += float(line) * float(y);
    }
    if (sum > 0.0F) all += double((sum_x + sum_y) / sum);
  }
  return all;
}

}  // namespace ovws::bench
