/// Monte-Carlo localisation errors of one spot of the lattice, cropped with its neighbours'
/// diffraction ripple.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// Localisation bench: one spot of the lattice at one light level, measured by one method. The
/// image is cropped around the spot and contains the neighbours' diffraction ripple.
struct SpotBench {
  Light light = Light::equal_peak;
  Method method;
  std::shared_ptr<Measurer> measurer;
  Image<float> light_e;  ///< electrons per pixel around the spot
  Vec2 at_px;            ///< noise-free spot position by the method; if not found: by the model
};

/// Localisation benches of all methods at both light levels, except the centroid of a fixed window.
std::vector<SpotBench> all_spot_benches();
SpotBench spot_bench(const Method& method, Light light, const SensorPair& sensors);

struct Cloud {
  std::vector<double> x_px, y_px;   ///< errors of each realisation
  std::vector<double> squares_px2;  ///< half of each squared error length: mean square per axis
  int lost = 0;
};

/// Tracks the spot in `realisations` noisy images. Starts lie within kStartWithin of the spot in
/// each axis. Each error is the difference from the noise-free result of the tracker with the same
/// start. Thread-safe.
Cloud cloud_of(const SpotBench& bench, double read_noise_e, int realisations, std::uint64_t seed);

/// Cramer-Rao bound of the spot's position, camera pixels RMS per axis. It uses the pixels up to
/// half the distance to the neighbours, including the diffraction ripple.
double bound_px(const SpotBench& bench, double read_noise_e);

}  // namespace ovws::study
