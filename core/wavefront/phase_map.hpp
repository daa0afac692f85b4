/// Phase map: the wavefront over the pupil as an image.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/image.hpp"

namespace ovws {

/// Phase map renderer: modes are precomputed on a grid, so that an image is one matrix product.
/// Immutable after construction.
class PhaseMap {
 public:
  /// Square image of size_px x size_px pixels, whose edges the pupil circle touches. Pixel (c, r)
  /// shows the pupil point ((2c + 1)/size - 1, (2r + 1)/size - 1) in units of the pupil's radius.
  PhaseMap(std::span<const int> modes_j, int size_px);

  int size_px() const { return size_; }
  /// Renders the wavefront in waves, NaN outside the pupil. `coefficients`: RMS-normalised waves in
  /// the order of `modes_j`. Thread-safe.
  void render(std::span<const float> coefficients, Image<float>& waves) const;

 private:
  int size_;
  std::vector<int> inside_;  ///< indices of the pixels in the pupil
  Eigen::MatrixXf basis_;    ///< inside_.size() x modes
};

}  // namespace ovws
