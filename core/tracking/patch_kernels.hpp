/// The loops over pixels that finding a spot is made of, for the CPU that is there.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace ovws {

/// Floats may be read this many past a patch's end, because rows are read in whole blocks of it.
constexpr int kPatchBlock = 16;

/// A rectangle of camera pixels, all of it inside the image; at least kPatchBlock columns.
struct PixelRect {
  const std::byte* first = nullptr;
  std::ptrdiff_t stride_bytes = 0;
  int columns = 0, rows = 0;
};

/// A rectangle of floats, `stride` from row to row; at least kPatchBlock columns.
struct FloatRect {
  const float* first = nullptr;
  std::ptrdiff_t stride = 0;
  int columns = 0, rows = 0;
};

/// A Gaussian along one axis: at the k-th place table[k] first ratio^k, of d = begin + k.
struct GaussianAxis {
  const float* table = nullptr;
  int padded = 0;  ///< floats of the table, a multiple of kPatchBlock; it ends in zeros
  float first = 0.0F, ratio = 1.0F;
  float begin = 0.0F;
};

/// Weights of a window along one axis: g, d g and d^2 g.
struct WindowAxis {
  const float* g = nullptr;
  const float* dg = nullptr;
  const float* ddg = nullptr;
  int count = 0;
  int padded = 0;  ///< floats behind each, a multiple of kPatchBlock; those after `count` are 0
};

/// Sums over a window of pixel * weights: one = gx gy, x = dx gx gy, xy = dx gx dy gy, …
struct WindowSums {
  float one = 0.0F, x = 0.0F, y = 0.0F, xx = 0.0F, xy = 0.0F, yy = 0.0F;
};

/// One build of the loops. All RT-safe; the builds agree to rounding, which is 1e-6 of the sum of
/// the terms' magnitudes.
struct PatchKernels {
  std::string_view name;
  /// Pixels of 8 or 16 bits as floats, rows without a gap; gives the darkest.
  float (*load8)(const PixelRect& from, float* out);
  float (*load16)(const PixelRect& from, float* out);
  float (*brightest)(const FloatRect& of);  ///< at least 0
  /// Sum of the squares of 1 -4 6 -4 1 along the rows; at least 4 columns more than a block.
  float (*fourth_differences)(const FloatRect& of);
  /// Writes g, d g and d^2 g, `padded` floats each; gives the sum of g.
  float (*axis)(const GaussianAxis& from, float* g, float* dg, float* ddg);
  /// `first`: the window's first pixel, `stride`: floats from row to row.
  WindowSums (*window)(const float* first, std::ptrdiff_t stride, const WindowAxis& across,
                       const WindowAxis& down);
};

/// Those that this CPU can run, the fastest last.
std::span<const PatchKernels> all_patch_kernels();

/// The fastest of them.
const PatchKernels& patch_kernels();

}  // namespace ovws
