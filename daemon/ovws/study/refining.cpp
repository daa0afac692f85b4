#include "daemon/ovws/study/refining.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace ovws::study {

Refiner refiner_of(const Geometry& geometry, int charge, const std::vector<int>& modes_j) {
  SensorConfig sensor = geometry.sensor;
  sensor.charge = charge;
  auto refiner = Refiner::make(sensor, geometry.slm, geometry.optics, kImagePx, kImagePx, modes_j);
  if (!refiner) throw std::logic_error(refiner.error().reason);
  return std::move(*refiner);
}

std::vector<double> refined_waves(Refiner& refiner, const Exposure& exposure, double read_noise_e,
                                  std::vector<double> start) {
  const double rounding_e = 0.3 / exposure.dn_per_e;
  const RefineCamera camera{1.0 / exposure.dn_per_e, std::hypot(read_noise_e, rounding_e),
                            exposure.black_dn};
  if (std::isnan(start.front())) start.assign(start.size(), 0.0);
  const auto done = refiner.refine(exposure.view(), camera, start);
  std::vector<double> waves(start.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; done && k < waves.size(); ++k) waves[k] = done->modes[k].waves;
  return waves;
}

}  // namespace ovws::study
