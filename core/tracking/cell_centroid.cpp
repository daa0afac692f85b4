#include "core/tracking/cell_centroid.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

template <class T>
std::optional<Vec2> centroid(const ImageView& image, int left, int top, int right, int bottom) {
  double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
  for (int y = top; y <= bottom; ++y) {
    const T* const row = image.row<T>(y);
    double row_sum = 0.0;
    for (int x = left; x <= right; ++x) {
      row_sum += double(row[x]);
      sum_x += double(row[x]) * x;
    }
    sum += row_sum;
    sum_y += row_sum * y;
  }
  if (!(sum > 0.0)) return std::nullopt;
  return Vec2{sum_x / sum, sum_y / sum};
}

}  // namespace

std::optional<Vec2> cell_centroid(const ImageView& image, Vec2 centre, int half_px) {
  const int x = int(std::lround(centre.x)), y = int(std::lround(centre.y));
  const int left = std::max(0, x - half_px), right = std::min(image.width - 1, x + half_px);
  const int top = std::max(0, y - half_px), bottom = std::min(image.height - 1, y + half_px);
  return bytes_per_pixel(image.format) == 1
             ? centroid<std::uint8_t>(image, left, top, right, bottom)
             : centroid<std::uint16_t>(image, left, top, right, bottom);
}

int cell_half_px(std::span<const Vec2> centres) {
  double least = 1e9;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) least = std::min(least, norm(centres[i] - centres[k]));
  }
  return int(0.5 * least);
}

}  // namespace ovws
