#include "core/tracking/cell_centroid.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/pixels.hpp"

namespace ovws {
std::optional<Vec2> cell_centroid(const ImageView& image, Vec2 centre, int half_px) {
  const int column = int(std::lround(centre.x)), row = int(std::lround(centre.y));
  const int left = std::max(0, column - half_px), top = std::max(0, row - half_px);
  const int right = std::min(image.width - 1, column + half_px);
  const int bottom = std::min(image.height - 1, row + half_px);
  double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
  visit_rows(image, left, top, right - left + 1, bottom - top + 1,
             [&](int x, int y, const auto* pixels, int count) {
               double run = 0.0;
               for (int i = 0; i < count; ++i) {
                 run += double(pixels[i]);
                 sum_x += double(pixels[i]) * (x + i);
               }
               sum += run;
               sum_y += run * y;
             });
  if (!(sum > 0.0)) return std::nullopt;
  return Vec2{sum_x / sum, sum_y / sum};
}

int cell_half_px(std::span<const Vec2> centres) {
  double least = 1e9;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) least = std::min(least, norm(centres[i] - centres[k]));
  }
  return int(0.5 * least);
}

}  // namespace ovws
