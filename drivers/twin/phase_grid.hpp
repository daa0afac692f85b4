/// Wavefronts over a lenslet array: sampled on a grid in the array's plane, and interpolated at the
/// samples of each lenslet.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/base/vec2.hpp"

namespace ovws::twin {

/// Square grid of points, centred on the array's centre; lengths in micrometres. Values on it are
/// matrices with indices (x, y).
struct PhaseGrid {
  double step_um = 1.0;
  int points = 0;  ///< along x and y

  /// A grid that reaches `reach_um` from the centre, and the points that interpolation needs.
  static PhaseGrid covering(double reach_um, double step_um);
  double first_um() const { return -step_um * (points - 1) / 2.0; }  ///< x and y of the first point
};

/// Interpolation of values on a grid at the samples of lenslets: six-point Lagrange interpolation
/// to 8 x 8 Chebyshev nodes of each lenslet, and from these to its samples. Immutable.
class LensletInterpolation {
 public:
  /// The samples of a lenslet are `samples` x `samples` points, in the middle of as many squares
  /// that fill a square of `side_um`. `along_x` and `along_y`: unit vectors of its sides.
  LensletInterpolation(const PhaseGrid& grid, const std::vector<Vec2>& centres_um, Vec2 along_x,
                       Vec2 along_y, double side_um, int samples);

  /// Values at the samples of a lenslet, indices (x, y).
  void at_samples(const Eigen::MatrixXf& values, std::size_t lenslet, Eigen::MatrixXf& out) const;

 private:
  static constexpr int kNodes = 8, kTaps = 6;
  using NodeMatrix = Eigen::Matrix<float, kNodes, kNodes>;
  struct Node {
    int x, y;  ///< first grid point
    Eigen::Matrix<float, kTaps, 1> along_x, along_y;
  };
  using Nodes = std::array<Node, kNodes * kNodes>;
  static Node node_at(const PhaseGrid& grid, Vec2 at_um);

  std::vector<Nodes> lenslets_;
  Eigen::Matrix<float, Eigen::Dynamic, kNodes> to_samples_;
};

}  // namespace ovws::twin
