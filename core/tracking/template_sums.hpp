/// The sums over a window of pixels that the matched filter is made of: its only hot loops.
#pragma once

#include <span>
#include <string_view>

#include "core/base/realtime.hpp"

namespace ovws {

/// Columns of a window are a multiple of this.
constexpr int kTemplateBlock = 16;

/// A template at one sub-pixel shift, row-major, borrowed from a TemplateBank. `cx` and `cy` are
/// the changes of `value` per pixel that the spot moves.
struct TemplateView {
  int columns = 0, rows = 0;
  const float* value = nullptr;
  const float* cx = nullptr;
  const float* cy = nullptr;
  const float* weight = nullptr;  ///< 0 outside the window's disc
};

/// Sums of weight * pixel * {1, value, cx, cy}.
struct TemplateMoments {
  float one = 0.0F, value = 0.0F, cx = 0.0F, cy = 0.0F;
};

/// D = background + amplitude value + move_x cx + move_y cy.
struct TemplateFit {
  float background = 0.0F, amplitude = 0.0F, move_x = 0.0F, move_y = 0.0F;
};

/// With r = D - fit, and e its difference from the pixel above.
struct ResidualSums {
  float square = 0.0F;      ///< sum of weight r^2
  float difference = 0.0F;  ///< sum of weight e^2 / 2: as large if r is noise, small if not
  float dark = 0.0F;        ///< sum of weight^2 e^2 / 2
  float bright = 0.0F;      ///< sum of weight^2 value e^2 / 2
};

/// One build of the loops. `pixels`: rows x columns. `line`: columns floats of working memory. All
/// RT-safe; the builds agree to rounding, which is 1e-5 of the sum of the terms' magnitudes.
struct TemplateKernels {
  std::string_view name;
  TemplateMoments (*moments)(const TemplateView& view, const float* pixels);
  ResidualSums (*residuals)(const TemplateView& view, const float* pixels, const TemplateFit& fit,
                            float* line);
};

/// Those that this CPU can run, the fastest last.
std::span<const TemplateKernels> template_kernels();

}  // namespace ovws
