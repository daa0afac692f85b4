/// One mode in growing steps, each image acquired as if nothing were known.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

/// What ended a climb.
enum class Limit {
  nothing,   ///< the last step was reached
  sampling,  ///< the SLM cannot show more
  leaving,   ///< a spot is within lambda/d of the image's edge
  crossing,  ///< two spots are within lambda/d of each other
  wrong,     ///< a spot was found where it is not
  refused    ///< a spot was there and not found
};
const char* name_of(Limit limit);

struct Climb {
  double waves = 0.0;  ///< RMS, without sign; up to here every spot was found, and none wrongly
  Limit limited_by = Limit::nothing;
};

struct ClimbSteps {
  double step_waves = 0.05;
  double most_waves = 2.0;  ///< RMS
  double snr = 10.0;        ///< peak, as of read_noise_of_snr: it fixes the read noise
  int realisations = 1;
};

/// A way to measure under a light, and how far it came in each realisation.
struct Climber {
  Method method;
  Light light;
  std::vector<Climb> climbs{};
};

/// Both charges at both lights (the vortex is the same at either), trackers of the daemon's.
std::vector<Climber> all_climbers();

/// Each of `climbers` climbs mode j towards `sign`. The same seed gives the same numbers.
std::vector<Climber> climb(std::vector<Climber> climbers, int j, double sign,
                           const ClimbSteps& steps, std::uint64_t seed);

/// Where geometric optics alone would end it, whatever the light: RMS waves, sign as given; NaN
/// beyond most_waves.
struct GeometricLimit {
  double leaving_waves, crossing_waves;
};
GeometricLimit geometric_limit(const Measurer& measurer, int j, double sign,
                               const ClimbSteps& steps);

}  // namespace ovws::study
