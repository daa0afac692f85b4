/// Deformable mirror in front of the sensor: Gaussian influence functions on a square grid.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/vec2.hpp"

namespace ovws::twin {

struct MirrorConfig {
  int actuators_across = 9;
  double coupling = 0.15;  ///< influence of an actuator at its neighbour's place, of 1 at its own

  friend bool operator==(const MirrorConfig&, const MirrorConfig&) = default;
};

/// Equally spaced positions along an axis of the pupil, in pupil radii from its centre.
struct PupilLine {
  double first, step;
  int count;
  double at(int k) const { return first + k * step; }
};

/// Positions of the actuators in pupil radii, sorted by y, then x. The grid's outermost actuators,
/// on the axes, are on the pupil's edge, so N across are 2 / (N - 1) radii apart. An actuator
/// exists within N / 2 distances of the centre: 9 across are 69.
std::vector<Vec2> actuator_positions(const MirrorConfig& mirror);

/// Deformable mirror, evaluated on one grid of positions. Immutable.
class DeformableMirror {
 public:
  DeformableMirror(const MirrorConfig& mirror, const PupilLine& x, const PupilLine& y);

  /// Wavefront in waves at the grid's positions, indices (x, y). `commands`: of each actuator, the
  /// wavefront in waves at its place if it acts alone; empty: all 0.
  Eigen::MatrixXf waves(const std::vector<double>& commands) const;

 private:
  MirrorConfig mirror_;
  Eigen::MatrixXf along_x_, along_y_;  ///< influence of columns and rows of actuators
};

}  // namespace ovws::twin
