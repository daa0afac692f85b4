/// Fast evaluation of a sum of Zernike modes on a pixel grid: along a row it is a polynomial in x.
/// A pixel costs a few multiply-adds for any number of modes.
#pragma once

#include <span>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

class WavefrontRows {
 public:
  /// Over a pupil of `diameter_px` centred on `centre_px`. Requires valid mode indices. Rows and
  /// columns are those that a camera sees through `turn` (PxPerCycle::seen).
  WavefrontRows(std::span<const Mode> modes, Vec2 centre_px, double diameter_px,
                const PxPerCycle& turn = 1.0);

  /// Waves at the pixels (first_x + k, y), k = 0 .. out.size() - 1. Also valid outside the pupil,
  /// where the polynomial continues. This and all methods below are thread-safe.
  void waves(int y, int first_x, std::span<double> out) const;
  /// The same for the slopes along x and y, waves per pixel.
  void slopes_x(int y, int first_x, std::span<double> out) const;
  void slopes_y(int y, int first_x, std::span<double> out) const;

  using Polynomial = std::vector<double>;  ///< by rising power
  /// Waves along row y as a polynomial of the position from the centre in pupil radii.
  void along_row(int y, Polynomial& p) const;
  double radius_px() const { return radius_px_; }

 private:
  void evaluate(const Polynomial& p, int first_x, std::span<double> out) const;

  Vec2 centre_px_;
  double radius_px_;
  std::vector<Polynomial> terms_;  ///< terms_[a]: the polynomial in y that multiplies x^a
};

}  // namespace ovws
