/// Pixel patches: a square of camera pixels around a start position, converted to floats.
#pragma once

#include <cstddef>
#include <span>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/patch_kernels.hpp"

namespace ovws {

/// Pixel patch, stored in a TrackScratch. Positions are image pixels; patch pixels outside the
/// image repeat the image's edge.
struct Patch {
  const float* pixels = nullptr;
  int x0 = 0, y0 = 0;                ///< position of pixels[0] in the image
  int side = 0;                      ///< number of rows, of columns, and the row stride in floats
  const ImageView* image = nullptr;  ///< as given to load_patch; must outlive the patch
  float darkest = 0.0F;

  const float* at(int x, int y) const { return pixels + std::ptrdiff_t(y - y0) * side + (x - x0); }
  /// Brightest pixel of the square of half-width `half` around `centre`, clipped at the patch.
  float brightest(Vec2 centre, int half) const OVWS_NONBLOCKING;
  /// Whether the image contains every pixel within `margin` pixels of `at` along x and y.
  bool holds(Vec2 at, double margin) const OVWS_NONBLOCKING;
  /// Reads the pixels around `at` into `samples`, if `at` is more than `spare_px` from the
  /// patch's middle along x or y. False, without an effect, if `at` is outside the image.
  bool follow(Vec2 at, int spare_px, std::span<float> samples) OVWS_NONBLOCKING;
};

/// Brightest pixel of the square of half-width `half` around `centre`, clipped at the image; 0 if
/// the square lies outside the image. RT-safe.
float brightest_pixel(const ImageView& image, Vec2 centre, int half) OVWS_NONBLOCKING;

/// Minimum half-width of a patch. The noise estimate (fourth_differences) needs kPatchBlock + 4
/// pixels in each row.
constexpr int kMinPatchHalf = (kPatchBlock + 4) / 2;

/// Number of floats that a patch of half-width `half` needs.
constexpr int patch_floats(int half) {
  return (2 * half + 1) * (2 * half + 1) + kPatchBlock;
}

/// Reads the square of half-width `half` (at least kMinPatchHalf) around the pixel (cx, cy) into
/// `samples`. The pixel (cx, cy) must be in the image.
Patch load_patch(const ImageView& image, int cx, int cy, int half,
                 std::span<float> samples) OVWS_NONBLOCKING;

}  // namespace ovws
