/// Moments of a patch under a Gaussian: the LG kernel's Psi, its Hessian, the weighted centroid.
#pragma once

#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/patch.hpp"

namespace ovws {

/// Moments of the intensity I under a Gaussian g: sums over the pixels p of g I, g dx I, … with
/// (dx, dy) = p - c and g = exp(-|p - c|^2 / w^2). Up to a constant, (x, y) is Psi of the LG
/// kernel. It is w^2/2 times the gradient of the smoothed image.
struct Moments {
  double one = 0.0;
  double x = 0.0, y = 0.0;
  double xx = 0.0, xy = 0.0, yy = 0.0;
  double weight = 0.0;  ///< sum of g

  /// Symmetric matrix d(x, y)/dc: w^2/2 times the Hessian of the smoothed image.
  struct Hessian {
    double xx = 0.0, xy = 0.0, yy = 0.0;
    double det() const { return xx * yy - xy * xy; }
    double trace() const { return xx + yy; }
  };
  Hessian hessian(double w) const {
    const double k = 2.0 / (w * w);
    return {k * xx - one, k * xy, k * yy - one};
  }
};

/// Gaussian window of 1/e radius w = `radius_px`, with tabulated weights. Immutable.
class GaussianWindow {
 public:
  explicit GaussianWindow(double radius_px);

  double radius_px() const { return radius_; }
  /// Half-width of the square of pixels that `at` sums: at least 2.9 w, so that a flat background
  /// cancels.
  int half_px() const { return half_; }
  /// Number of floats of scratch memory that `at` needs.
  int scratch_floats() const;

  /// Centre pixel of the summed square, with hysteresis: it follows the iteration only when the
  /// position is most of a pixel away. Without hysteresis a position between two pixels might never
  /// converge, because each step would change the rim of the square.
  struct Centre {
    int x = 0, y = 0;
    explicit Centre(Vec2 at);
    void follow(Vec2 at) OVWS_NONBLOCKING;
  };

  /// Moments about the position `c`. The patch must extend half_px() around `centre`. RT-safe.
  Moments at(const Patch& patch, Vec2 c, Centre centre,
             std::span<float> scratch) const OVWS_NONBLOCKING;

 private:
  struct Axis {
    WindowAxis weights;
    double sum = 0.0;  ///< sum of the weights g
  };
  Axis axis(double c, int first, float* out) const;

  double radius_;
  int half_;
  std::vector<float> table_;  ///< exp(-k^2/w^2), k = -half .. half, then zeros
};

}  // namespace ovws
