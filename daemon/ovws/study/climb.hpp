/// Amplitude ramp of one mode: the amplitude grows in steps, and each image is acquired without
/// history.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// What ended the ramp.
enum class Limit {
  nothing,   ///< the last step was reached
  sampling,  ///< the SLM cannot sample a larger amplitude
  leaving,   ///< a spot is within lambda/d of the image's edge
  crossing,  ///< two spots are within lambda/d of each other
  wrong,     ///< a spot was found at a wrong place
  refused    ///< an existing spot was not found
};
const char* name_of(Limit limit);

struct Climb {
  double waves = 0.0;  ///< RMS, unsigned: up to this amplitude every spot was found at its place
  Limit limited_by = Limit::nothing;
};

struct ClimbSteps {
  double step_waves = 0.05;
  double max_waves = 2.0;  ///< RMS
  double snr = 10.0;       ///< peak SNR; sets the read noise by read_noise_of_snr
  int realisations = 1;
};

/// A method at one light level, and the amplitude that it reached in each realisation.
struct Climber {
  Method method;
  Light light;
  std::vector<Climb> climbs{};
};

/// Both charges at both light levels (the vortex is the same at either), with the daemon's
/// trackers.
std::vector<Climber> all_climbers();

/// Ramps mode j in direction `sign` for all `climbers`. The same seed gives the same numbers.
std::vector<Climber> climb(std::vector<Climber> climbers, int j, double sign,
                           const ClimbSteps& steps, std::uint64_t seed);

/// The amplitudes at which geometry alone ends the ramp, at any light level: RMS waves, unsigned;
/// NaN if it is above max_waves.
struct GeometricLimit {
  double leaving_waves, crossing_waves;
};
GeometricLimit geometric_limit(const Measurer& measurer, int j, double sign,
                               const ClimbSteps& steps);

}  // namespace ovws::study
