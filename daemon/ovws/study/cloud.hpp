/// Monte-Carlo localisation errors of one spot of the lattice, cropped with its neighbours'
/// diffraction ripple.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// One spot of the lattice at one intensity, cropped with its neighbours' diffraction ripple and
/// measured by one method.
struct SpotBench {
  Light light = Light::equal_peak;
  Method method;
  std::shared_ptr<Measurer> measurer;
  Image<float> light_e;  ///< the image around the base spot
  Vec2 at_px;            ///< its noise-free position by the method; if not found: by the model
};

/// Every method at both light levels.
std::vector<SpotBench> all_spot_benches();
SpotBench spot_bench(const Method& method, Light light, const std::shared_ptr<SensorModel>& model,
                     const std::shared_ptr<SensorModel>& vortex);

struct Cloud {
  std::vector<double> x_px, y_px;   ///< errors of each realisation
  std::vector<double> squares_px2;  ///< half of each squared distance: mean square per axis
  int lost = 0;
};

/// Tracks the spot in `realisations` noisy images. Starts lie within 0.3 lambda/d of the spot in
/// each axis. Errors are relative to the same tracker's noise-free result from the same start.
/// Thread-safe.
Cloud cloud_of(const SpotBench& bench, double read_noise_e, int realisations, std::uint64_t seed);

/// The Cramer-Rao bound for the position of the tracked spot, including its diffraction ripple, up
/// to half the distance to its neighbours; camera pixels RMS per axis.
double bound_px(const SpotBench& bench, double read_noise_e);

}  // namespace ovws::study
