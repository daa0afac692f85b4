#include "core/tracking/patch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

// Block of an inner loop, pixels. The compiler vectorises loops of constant length without aliasing
// (8-bit pixels may alias any type).
constexpr int kBlock = 16;

float load_run(const PixelRect& run, const std::uint8_t*, float* out) {
  return load8(run, out);
}
float load_run(const PixelRect& run, const std::uint16_t*, float* out) {
  return load16(run, out);
}

/// Destination of a copy: a rectangle of floats, and the rectangle of image pixels to copy.
struct Target {
  int left, top, columns, rows;
  float* out;

  float* row(int y) const { return out + std::ptrdiff_t(y) * columns; }
  bool inside(const ImageView& image) const {
    return left >= 0 && top >= 0 && left + columns <= image.width && top + rows <= image.height;
  }
};

/// Range of `count` pixel indices from `start` on, clipped to [0, size). If no index is inside, the
/// range is the nearest one.
struct Span {
  Span(int start, int count, int size)
      : first(std::clamp(start, 0, size - 1)), last(std::clamp(start + count - 1, 0, size - 1)) {}
  int first, last;
  int count() const { return last - first + 1; }
};

/// Copies image pixels to floats and returns the darkest. Pixels outside the image repeat its edge.
float load_or_repeat_edge(const ImageView& image, const Target& to) {
  const Span across(to.left, to.columns, image.width), down(to.top, to.rows, image.height);
  float darkest = std::numeric_limits<float>::max();
  const auto place = [](int at, int begin, int size) {
    return std::clamp(at - begin, 0, size - 1);
  };
  visit_rows(image, across.first, down.first, across.count(), down.count(),
             [&](int x, int y, const auto* pixels, int count) {
               float* const out = to.row(place(y, to.top, to.rows)) + place(x, to.left, to.columns);
               if (count >= kPatchBlock) {
                 const PixelRect run{reinterpret_cast<const std::byte*>(pixels), 0, count, 1};
                 darkest = std::min(darkest, load_run(run, pixels, out));
                 return;
               }
               for (int i = 0; i < count; ++i) {
                 out[i] = float(pixels[i]);
                 darkest = std::min(darkest, out[i]);
               }
             });
  if (to.inside(image)) return darkest;
  const int left = place(across.first, to.left, to.columns);
  const int right = place(across.last, to.left, to.columns);
  const int top = place(down.first, to.top, to.rows);
  const int bottom = place(down.last, to.top, to.rows);
  for (int y = top; y <= bottom; ++y) {
    float* const row = to.row(y);
    std::fill(row, row + left, row[left]);
    std::fill(row + right + 1, row + to.columns, row[right]);
  }
  for (int y = 0; y < top; ++y) std::copy_n(to.row(top), to.columns, to.row(y));
  for (int y = bottom + 1; y < to.rows; ++y) std::copy_n(to.row(bottom), to.columns, to.row(y));
  return darkest;
}

float load_patch_pixels(const ImageView& image, const Target& to) {
  if (!in_place(image) || !to.inside(image)) return load_or_repeat_edge(image, to);
  const int bytes = bytes_in_place(image);
  const PixelRect rect{image.row<std::byte>(to.top) + std::ptrdiff_t(to.left) * bytes,
                       image.stride_bytes, to.columns, to.rows};
  return bytes == 1 ? load8(rect, to.out) : load16(rect, to.out);
}

template <class T>
float brightest_of(const T* pixels, int count) {
  std::array<T, kBlock> most{};
  int x = 0;
  for (; x + kBlock <= count; x += kBlock) {
    for (int i = 0; i < kBlock; ++i) most[i] = std::max(most[i], pixels[x + i]);
  }
  for (; x < count; ++x) most[0] = std::max(most[0], pixels[x]);
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
  float most = 0.0F;
  visit_rows(image, left, top, right - left, bottom - top,
             [&](int, int, const auto* pixels, int count) {
               most = std::max(most, brightest_of(pixels, count));
             });
  return most;
}

float Patch::brightest(Vec2 centre, int half) const {
  const int cx = int(std::lround(centre.x)), cy = int(std::lround(centre.y));
  const int left = std::max(cx - half, x0), right = std::min(cx + half + 1, x0 + side);
  const int top = std::max(cy - half, y0), bottom = std::min(cy + half + 1, y0 + side);
  if (left >= right || top >= bottom) return 0.0F;
  if (right - left >= kPatchBlock) {
    return ovws::brightest({at(left, top), side, right - left, bottom - top});
  }
  float most = 0.0F;
  for (int y = top; y < bottom; ++y) {
    most = std::max(most, *std::max_element(at(left, y), at(left, y) + (right - left)));
  }
  return most;
}

bool Patch::holds(Vec2 at, double margin) const {
  return at.x - margin >= 0.0 && at.y - margin >= 0.0 && at.x + margin <= image->width - 1.0 &&
         at.y + margin <= image->height - 1.0;
}

bool Patch::follow(Vec2 at, int spare_px, std::span<float> samples) {
  if (!holds(at, 0.0)) return false;
  const int half = side / 2, cx = int(std::lround(at.x)), cy = int(std::lround(at.y));
  if (std::abs(cx - x0 - half) > spare_px || std::abs(cy - y0 - half) > spare_px) {
    *this = load_patch(*image, cx, cy, half, samples);
  }
  return true;
}

Patch load_patch(const ImageView& image, int cx, int cy, int half, std::span<float> samples) {
  Patch patch;
  patch.pixels = samples.data();
  patch.x0 = cx - half;
  patch.y0 = cy - half;
  patch.side = 2 * half + 1;
  patch.image = &image;
  patch.darkest =
      load_patch_pixels(image, {patch.x0, patch.y0, patch.side, patch.side, samples.data()});
  std::fill_n(samples.data() + std::ptrdiff_t(patch.side) * patch.side, kPatchBlock, 0.0F);
  return patch;
}

}  // namespace ovws
