/// SIMD pixel kernels of the trackers, with run-time dispatch (Highway). All kernels are RT-safe.
#pragma once

#include <cstddef>

namespace ovws {

/// Block size in floats. Kernels read rows in whole blocks, up to one block past a patch's end.
constexpr int kPatchBlock = 16;

/// Rectangle of camera pixels that lies inside the image; at least kPatchBlock columns.
struct PixelRect {
  const std::byte* first = nullptr;
  std::ptrdiff_t stride_bytes = 0;
  int columns = 0, rows = 0;
};

/// Rectangle of floats with a row stride in floats; at least kPatchBlock columns.
struct FloatRect {
  const float* first = nullptr;
  std::ptrdiff_t stride = 0;
  int columns = 0, rows = 0;
};

/// Gaussian along one axis: its weight at d = begin + k pixels is table[k] * first * ratio^k.
struct GaussianAxis {
  const float* table = nullptr;
  int padded = 0;  ///< length of the table, a multiple of kPatchBlock; padded with zeros
  float first = 0.0F, ratio = 1.0F;
  float begin = 0.0F;
};

/// Weights of a window along one axis: g, d g and d^2 g.
struct WindowAxis {
  const float* g = nullptr;
  const float* dg = nullptr;
  const float* ddg = nullptr;
  int count = 0;
  int padded = 0;  ///< length of each array, a multiple of kPatchBlock; 0 from `count` on
};

/// Moments of a window: sums of pixel * weight with the weights gx gy for `one`, dx gx gy for `x`,
/// …
struct WindowSums {
  float one = 0.0F, x = 0.0F, y = 0.0F, xx = 0.0F, xy = 0.0F, yy = 0.0F;
};

/// Converts 8-bit or 16-bit pixels to floats with contiguous rows; returns the darkest pixel.
float load8(const PixelRect& from, float* out);
float load16(const PixelRect& from, float* out);
float brightest(const FloatRect& of);  ///< returns the brightest value, at least 0
/// Returns the sum of the squared fourth differences (1 -4 6 -4 1) along the rows. Requires at
/// least kPatchBlock + 4 columns.
float fourth_differences(const FloatRect& of);
/// Writes the weights g, d g and d^2 g, `padded` floats each; returns the sum of g.
float gaussian_axis(const GaussianAxis& from, float* g, float* dg, float* ddg);
/// Returns the moments of a window. `first`: its first pixel; `stride`: row stride in floats.
WindowSums window_sums(const float* first, std::ptrdiff_t stride, const WindowAxis& across,
                       const WindowAxis& down);

}  // namespace ovws
