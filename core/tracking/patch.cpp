#include "core/tracking/patch.hpp"

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
void load_at_edge(const ImageView& image, const Patch& patch, float* out) {
  for (int k = 0; k < patch.side; ++k, out += patch.side) {
    const T* row = image.row<T>(std::clamp(patch.y0 + k, 0, image.height - 1));
    for (int x = 0; x < patch.side; ++x) {
      out[x] = float(row[std::clamp(patch.x0 + x, 0, image.width - 1)]);
    }
  }
}

/// Gives the darkest.
float load_pixels(const ImageView& image, const Patch& patch, float* out) {
  const int bytes = bytes_per_pixel(image.format);
  const bool inside = patch.x0 >= 0 && patch.y0 >= 0 && patch.x0 + patch.side <= image.width &&
                      patch.y0 + patch.side <= image.height;
  const PatchKernels& kernels = patch_kernels();
  if (inside) {
    const PixelRect rect{image.row<std::byte>(patch.y0) + std::ptrdiff_t(patch.x0) * bytes,
                         image.stride_bytes, patch.side, patch.side};
    return bytes == 1 ? kernels.load8(rect, out) : kernels.load16(rect, out);
  }
  if (bytes == 1) {
    load_at_edge<std::uint8_t>(image, patch, out);
  } else {
    load_at_edge<std::uint16_t>(image, patch, out);
  }
  return *std::min_element(out, out + std::ptrdiff_t(patch.side) * patch.side);
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
  if (left >= right || top >= bottom) return 0.0F;
  if (right - left >= kPatchBlock) {
    return patch_kernels().brightest({at(left, top), side, right - left, bottom - top});
  }
  float most = 0.0F;
  for (int y = top; y < bottom; ++y) {
    most = std::max(most, *std::max_element(at(left, y), at(left, y) + (right - left)));
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
  patch.darkest = load_pixels(image, patch, samples.data());
  std::fill_n(samples.data() + std::ptrdiff_t(patch.side) * patch.side, kPatchBlock, 0.0F);
  return patch;
}

}  // namespace ovws
