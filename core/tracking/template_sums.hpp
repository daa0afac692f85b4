/// SIMD kernels of the matched filter: weighted sums over a window of pixels.
#pragma once

#include <span>
#include <string_view>

#include "core/base/realtime.hpp"

namespace ovws {

/// Columns of a window are a multiple of this.
constexpr int kTemplateBlock = 16;

/// A template at one sub-pixel shift, row-major, borrowed from a TemplateBank. `cx` and `cy` are
/// the derivatives of `value` with respect to the spot's position.
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

/// Sums over the residual r = D - fit and its difference e from the pixel above.
struct ResidualSums {
  float square = 0.0F;      ///< sum of weight r^2
  float difference = 0.0F;  ///< sum of weight e^2 / 2: as `square` for white noise, else small
  float dark = 0.0F;        ///< sum of weight^2 e^2 / 2
  float bright = 0.0F;      ///< sum of weight^2 value e^2 / 2
};

/// The kernels built for one instruction set, all RT-safe. `pixels`: rows x columns. `line`:
/// columns floats of working memory. The builds agree to rounding: 1e-5 of the sum of the terms'
/// magnitudes.
struct TemplateKernels {
  std::string_view name;
  TemplateMoments (*moments)(const TemplateView& view, const float* pixels);
  ResidualSums (*residuals)(const TemplateView& view, const float* pixels, const TemplateFit& fit,
                            float* line);
};

/// The builds that this CPU can run, fastest last.
std::span<const TemplateKernels> template_kernels();

}  // namespace ovws
