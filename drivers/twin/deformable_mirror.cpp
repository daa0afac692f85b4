#include "drivers/twin/deformable_mirror.hpp"

#include <cmath>

namespace ovws::twin {
namespace {

double distance_radii(const MirrorConfig& mirror) {
  return 2.0 / (mirror.actuators_across - 1);
}

/// Calls visit(column, row) for each actuator.
template <class Visit>
void for_actuators(const MirrorConfig& mirror, const Visit& visit) {
  const int across = mirror.actuators_across;
  for (int row = 0; row < across; ++row) {
    for (int column = 0; column < across; ++column) {
      const double x = column - (across - 1) / 2.0, y = row - (across - 1) / 2.0;
      if (x * x + y * y <= across * across / 4.0) visit(column, row);
    }
  }
}

/// Influence of each line of actuators at each position. A Gaussian is a product of these.
Eigen::MatrixXf influences(const MirrorConfig& mirror, const PupilLine& line) {
  Eigen::MatrixXf influence(line.count, mirror.actuators_across);
  for (int k = 0; k < line.count; ++k) {
    for (int n = 0; n < mirror.actuators_across; ++n) {
      const double away = (line.at(k) + 1.0) / distance_radii(mirror) - n;
      influence(k, n) = float(std::pow(mirror.coupling, away * away));
    }
  }
  return influence;
}

}  // namespace

std::vector<Vec2> actuator_positions(const MirrorConfig& mirror) {
  std::vector<Vec2> positions;
  for_actuators(mirror, [&](int column, int row) {
    const double distance = distance_radii(mirror);
    positions.push_back({column * distance - 1.0, row * distance - 1.0});
  });
  return positions;
}

DeformableMirror::DeformableMirror(const MirrorConfig& mirror, const PupilLine& x,
                                   const PupilLine& y)
    : mirror_(mirror), along_x_(influences(mirror, x)), along_y_(influences(mirror, y)) {}

Eigen::MatrixXf DeformableMirror::waves(const std::vector<double>& commands) const {
  const int across = mirror_.actuators_across;
  Eigen::MatrixXf grid = Eigen::MatrixXf::Zero(across, across);
  std::size_t n = 0;
  for_actuators(mirror_, [&](int column, int row) {
    if (n < commands.size()) grid(column, row) = float(commands[n++]);
  });
  return along_x_ * grid * along_y_.transpose();
}

}  // namespace ovws::twin
