#include "daemon/ovwsd/layout/slope_operator.hpp"

#include <algorithm>
#include <numeric>

#include "core/wavefront/reconstructor.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

constexpr double kMaxCondition = 1000.0;
/// Light that does not fill the pupil leaves part of it unmeasured. A mode that differs from others
/// mainly there would have the errors of all slopes, much enlarged. A pupil full of light has 25.
constexpr double kMaxLensletCondition = 40.0;

}  // namespace

std::vector<int> reconstructed_modes(const SensorConfig& sensor) {
  const int modes = std::min(optimal_mode_count(sensor.subapertures_across), kMaxZernikeIndex);
  std::vector<int> modes_j(static_cast<std::size_t>(modes));
  std::iota(modes_j.begin(), modes_j.end(), 1);
  return modes_j;
}

ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            const TrackingConfig& tracking, const PxPerCycle& map) {
  return slope_operator(lattice, sensor, tilt_radii(lattice, tracking), map);
}

ModeOperator slope_operator(const Lattice& lattice, const SensorConfig& sensor,
                            std::span<const double> tilt_radii, const PxPerCycle& map) {
  ModeOperator made{OperatorKind::slopes, reconstructed_modes(sensor), {}};
  made.slopes = slope_matrix(lattice, sensor, made.modes_j, tilt_radii, map);
  const double most = sensor.lenslets.empty() ? kMaxCondition : kMaxLensletCondition;
  made.modes_j.resize(std::size_t(determined_modes(made.slopes, most)));
  made.slopes.conservativeResize(Eigen::NoChange, Eigen::Index(made.modes_j.size()));
  return made;
}

}  // namespace ovws
