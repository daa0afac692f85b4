#include "daemon/ovws/study/wavefront_bound.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/wavefront/refine.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {

double wavefront_bound_rad2(const Geometry& geometry, int charge, std::span<const Mode> modes,
                            const Image<float>& light_e, double read_noise_e) {
  SensorConfig sensor = geometry.sensor;
  sensor.charge = charge;
  std::vector<int> modes_j(std::size_t(optimal_mode_count(sensor.subapertures_across)));
  std::iota(modes_j.begin(), modes_j.end(), 1);
  std::vector<double> truth(modes_j.size(), 0.0);
  for (const Mode& mode : modes) truth[std::size_t(mode.j - 1)] = mode.waves;
  auto refiner =
      Refiner::make(sensor, geometry.slm, geometry.optics, light_e.width, light_e.height, modes_j);
  if (!refiner) return kUnknown;
  // Fit the noise-free image with the noisy image's weights: the covariance is then at the truth.
  const auto found = refiner->refine(light_e, {1.0, read_noise_e}, truth);
  if (!found) return kUnknown;
  return 4.0 * std::numbers::pi * std::numbers::pi * found->covariance.trace();
}

}  // namespace ovws::study
