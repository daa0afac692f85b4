/// One spot by itself, and what a tracker makes of it under noise.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// A spot, a light, a method.
struct SpotBench {
  Light light = Light::equal_peak;
  Method method;
  std::shared_ptr<Measurer> measurer;
  Image<float> light_e;  ///< the image around the base spot
  Vec2 at_px;  ///< the spot in it, as the method reads it without noise; if it cannot: the model's
};

/// Every method at both lights.
std::vector<SpotBench> all_spot_benches();
SpotBench spot_bench(const Method& method, Light light, const std::shared_ptr<SensorModel>& model,
                     const std::shared_ptr<SensorModel>& vortex);

struct Cloud {
  std::vector<double> x_px, y_px;   ///< errors of each realisation
  std::vector<double> squares_px2;  ///< half of each squared distance: an axis's share
  int lost = 0;
};

/// Starts lie within 0.3 lambda/d of the spot, each way. Errors are against the same tracker's own
/// reading without noise from the same start. Thread-safe.
Cloud cloud_of(const SpotBench& bench, double read_noise_e, int realisations, std::uint64_t seed);

/// The Cramer-Rao bound of the very spot that is tracked, with its ripple, up to half the way to
/// its neighbours; camera pixels RMS per axis.
double bound_px(const SpotBench& bench, double read_noise_e);

}  // namespace ovws::study
