/// Fast evaluation of a sum of Zernike modes on a pixel grid. Along a row the sum is one polynomial
/// in x, so a pixel costs a few multiply-adds for any number of modes.
#pragma once

#include <span>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

class WavefrontRows {
 public:
  /// Prepares `modes` over a pupil of `diameter_px` centred on `centre_px`. Requires valid mode
  /// indices. For a rotated or mirrored camera, pass its `turn`: rows and columns are then along
  /// the camera's axes (PxPerCycle::seen).
  WavefrontRows(std::span<const Mode> modes, Vec2 centre_px, double diameter_px,
                const PxPerCycle& turn = 1.0);

  /// Wavefront in waves at the pixels (first_x + k, y), k = 0 .. out.size() - 1. Also defined
  /// outside the pupil, where the polynomial continues. All const methods are thread-safe.
  void waves(int y, int first_x, std::span<double> out) const;
  /// Slopes of the wavefront along x or y at these pixels, waves per pixel.
  void slopes_x(int y, int first_x, std::span<double> out) const;
  void slopes_y(int y, int first_x, std::span<double> out) const;

  using Polynomial = std::vector<double>;  ///< coefficients by rising power
  /// Polynomial `p` of the wavefront along row y, in waves. Its variable is x from the pupil's
  /// centre in pupil radii.
  void along_row(int y, Polynomial& p) const;
  double radius_px() const { return radius_px_; }

 private:
  void evaluate(const Polynomial& p, int first_x, std::span<double> out) const;

  Vec2 centre_px_;
  double radius_px_;
  std::vector<Polynomial> terms_;  ///< terms_[a]: the polynomial in y that multiplies x^a
};

}  // namespace ovws
