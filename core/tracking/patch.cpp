#include "core/tracking/patch.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace ovws {
namespace {

// A constant number of pixels a turn, and no aliasing (8-bit pixels may alias anything), lets the
// compiler use its vector instructions.
constexpr int kBlock = 16;

template <class T>
void convert_block(const T* __restrict in, float* __restrict out) {
  for (int i = 0; i < kBlock; ++i) out[i] = float(in[i]);
}

/// The last block may overlap the one before.
template <class T>
void convert(const T* in, int count, float* out) {
  int k = 0;
  for (; k + kBlock <= count; k += kBlock) convert_block(in + k, out + k);
  if (k < count && count >= kBlock) {
    return convert_block(in + count - kBlock, out + count - kBlock);
  }
  for (; k < count; ++k) out[k] = float(in[k]);
}

template <class T>
void load_rows(const ImageView& image, const Patch& patch, float* out) {
  const int first = std::max(patch.x0, 0);
  const int last = std::min(patch.x0 + patch.side, image.width);  // one past
  for (int k = 0; k < patch.side; ++k, out += patch.side) {
    const T* row = image.row<T>(std::clamp(patch.y0 + k, 0, image.height - 1));
    std::fill(out, out + (first - patch.x0), float(row[0]));
    convert(row + first, last - first, out + (first - patch.x0));
    std::fill(out + (last - patch.x0), out + patch.side, float(row[image.width - 1]));
  }
  std::fill(out, out + kPatchSlack, 0.0F);
}

template <class T>
void load_rectangle_at_edge(const ImageView& image, int left, int top, int columns, int rows,
                            float* out) {
  const auto row_at = [&](int y) { return image.row<T>(std::clamp(y, 0, image.height - 1)); };
  const auto column_at = [&](int x) { return std::clamp(x, 0, image.width - 1); };
  const float offset = float(row_at(top)[column_at(left)]);
  for (int k = 0; k < rows; ++k, out += columns) {
    const T* row = row_at(top + k);
    for (int x = 0; x < columns; ++x) out[x] = float(row[column_at(left + x)]) - offset;
  }
}

template <class T>
void load_rectangle(const ImageView& image, int left, int top, int columns, int rows,
                    float* __restrict out) {
  if (left < 0 || top < 0 || left + columns > image.width || top + rows > image.height) {
    return load_rectangle_at_edge<T>(image, left, top, columns, rows, out);
  }
  const float offset = float(image.row<T>(top)[left]);
  for (int k = 0; k < rows; ++k, out += columns) {
    const T* __restrict row = image.row<T>(top + k) + left;
    for (int x = 0; x < columns; x += kBlock) {
      for (int i = 0; i < kBlock; ++i) out[x + i] = float(row[x + i]) - offset;
    }
  }
}

template <class T>
float brightest_of(const ImageView& image, int left, int right, int top, int bottom) {
  std::array<T, kBlock> most{};
  for (int y = top; y < bottom; ++y) {
    const T* row = image.row<T>(y);
    int x = left;
    for (; x + kBlock <= right; x += kBlock) {
      for (int i = 0; i < kBlock; ++i) most[i] = std::max(most[i], row[x + i]);
    }
    for (; x < right; ++x) most[0] = std::max(most[0], row[x]);
  }
  return float(*std::max_element(most.begin(), most.end()));
}

}  // namespace

float brightest_pixel(const ImageView& image, Vec2 centre, int half) {
  const auto inside = [](double at, int size) {
    return int(std::lround(std::clamp(std::isnan(at) ? -1.0 : at, -1.0, double(size))));
  };
  const int cx = inside(centre.x, image.width), cy = inside(centre.y, image.height);
  const int left = std::max(cx - half, 0), right = std::min(cx + half + 1, image.width);
  const int top = std::max(cy - half, 0), bottom = std::min(cy + half + 1, image.height);
  return bytes_per_pixel(image.format) == 1
             ? brightest_of<std::uint8_t>(image, left, right, top, bottom)
             : brightest_of<std::uint16_t>(image, left, right, top, bottom);
}

void load_window(const ImageView& image, int left, int top, int columns, int rows, float* out) {
  if (bytes_per_pixel(image.format) == 1) {
    load_rectangle<std::uint8_t>(image, left, top, columns, rows, out);
  } else {
    load_rectangle<std::uint16_t>(image, left, top, columns, rows, out);
  }
}

float Patch::brightest(Vec2 centre, int half) const {
  const int cx = int(std::lround(centre.x)), cy = int(std::lround(centre.y));
  const int left = std::max(cx - half, x0), right = std::min(cx + half + 1, x0 + side);
  const int top = std::max(cy - half, y0), bottom = std::min(cy + half + 1, y0 + side);
  float most = 0.0F;
  for (int y = top; y < bottom && left < right; ++y) {
    most = std::max(most, Eigen::Map<const Eigen::ArrayXf>(at(left, y), right - left).maxCoeff());
  }
  return most;
}

bool Patch::holds(Vec2 at, double margin) const {
  return at.x - margin >= 0.0 && at.y - margin >= 0.0 && at.x + margin <= image_width - 1.0 &&
         at.y + margin <= image_height - 1.0;
}

Patch load_patch(const ImageView& image, int cx, int cy, int half, std::span<float> samples) {
  Patch patch;
  patch.pixels = samples.data();
  patch.x0 = cx - half;
  patch.y0 = cy - half;
  patch.side = 2 * half + 1;
  patch.image_width = image.width;
  patch.image_height = image.height;
  if (bytes_per_pixel(image.format) == 1) {
    load_rows<std::uint8_t>(image, patch, samples.data());
  } else {
    load_rows<std::uint16_t>(image, patch, samples.data());
  }
  patch.darkest =
      Eigen::Map<const Eigen::ArrayXf>(patch.pixels, Eigen::Index(patch.side) * patch.side)
          .minCoeff();
  return patch;
}

}  // namespace ovws
