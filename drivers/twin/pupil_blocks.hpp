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

/// 96 blocks across the pupil. Immutable.
class PupilBlocks {
 public:
  static constexpr int kModes = 21;  ///< j = 0 .. 20

  /// `amplitude`: of the light at each pixel, 0 where the field is to be ignored. Blocks with at
  /// most a quarter of the brightest block's sum are left out.
  PupilBlocks(Image<float> amplitude, Vec2 centre_px, double diameter_px);

  int count() const { return int(weights_.size()); }
  const Eigen::VectorXd& weights() const {
    return weights_;
  }  ///< sum of the amplitudes of each block
  /// Z_j at each block's amplitude-weighted centre, count() x kModes.
  const Eigen::MatrixXd& modes() const { return modes_; }
  /// Pairs of adjacent blocks, side by side or one below the other.
  const std::vector<std::pair<int, int>>& neighbours() const { return neighbours_; }

  /// For each block the sum of field * exp(-2 pi i waves(modes)). `field`: of the amplitude's size;
  /// null: the amplitude itself.
  Eigen::VectorXcd sums(const Image<std::complex<float>>* field, std::span<const Mode> modes) const;

  /// Smooths block sums by diffusion between neighbours: a ripple of 12 cycles across the pupil
  /// keeps 4/5 of its amplitude, one with a period of 4 blocks along both axes 1/8.
  Eigen::VectorXcd smoothed(Eigen::VectorXcd sums) const;

 private:
  std::size_t bin(int x, int y) const;
  void place_blocks();
  void join_neighbours();

  Image<float> amplitude_;
  Vec2 centre_px_;
  double diameter_px_;
  int step_px_, first_x_px_, first_y_px_, across_;
  std::vector<int> number_;  ///< block of each bin; -1: left out
  Eigen::VectorXd weights_;
  Eigen::MatrixXd modes_;
  std::vector<std::pair<int, int>> neighbours_;
};

}  // namespace ovws::twin
