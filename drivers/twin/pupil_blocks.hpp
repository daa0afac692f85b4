/// Block sums of a field over the pupil. Summing over small square blocks removes what varies from
/// pixel to pixel, such as the other diffraction orders of a grating.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <span>
#include <utility>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/zernike.hpp"

namespace ovws::twin {

/// Grid of square blocks over the pupil, about 96 across. Immutable.
class PupilBlocks {
 public:
  static constexpr int kModes = 21;  ///< j = 0 .. 20

  /// `amplitude`: light amplitude at each pixel; 0 excludes the pixel. Blocks with an amplitude sum
  /// of at most a quarter of the brightest block's sum are excluded.
  PupilBlocks(Image<float> amplitude, Vec2 centre_px, double diameter_px);

  int count() const { return int(weights_.size()); }
  const Eigen::VectorXd& weights() const {
    return weights_;
  }  ///< sum of the amplitudes of each block
  /// Zernike polynomials Z_j at each block's amplitude-weighted centre, count() x kModes.
  const Eigen::MatrixXd& modes() const { return modes_; }
  /// Pairs of adjacent blocks, side by side or one below the other.
  const std::vector<std::pair<int, int>>& neighbours() const { return neighbours_; }

  /// Block sums of field * exp(-2 pi i waves(modes)). `field` has the size of the amplitude; if it
  /// is null, the amplitude takes its place.
  Eigen::VectorXcd sums(const Image<std::complex<float>>* field, std::span<const Mode> modes) const;

  /// Smooths block sums by diffusion between neighbours. A ripple of 12 cycles across the pupil
  /// keeps 4/5 of its amplitude; a ripple with a period of 4 blocks along x and y keeps 1/8.
  Eigen::VectorXcd smoothed(Eigen::VectorXcd sums) const;

 private:
  std::size_t bin(int x, int y) const;
  void place_blocks();
  void join_neighbours();

  Image<float> amplitude_;
  Vec2 centre_px_;
  double diameter_px_;
  int step_px_, first_x_px_, first_y_px_, across_;
  std::vector<int> number_;  ///< block number of each grid bin; -1: excluded
  Eigen::VectorXd weights_;
  Eigen::MatrixXd modes_;
  std::vector<std::pair<int, int>> neighbours_;
};

}  // namespace ovws::twin
