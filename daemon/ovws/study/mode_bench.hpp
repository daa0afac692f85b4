/// How exactly a lattice of spots tells a number of modes: by positions, by shapes, and at most.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {

/// Normalisation of the light at which lattices and charges are compared.
enum class Budget {
  peak,    ///< kPeakE in the brightest pixel: the camera's full well is the limit
  photons  ///< kPhotonsE in all spots together: the laser is the limit
};
const char* name_of(Budget budget);
constexpr double kPhotonsE = 19 * 20'000.0;
constexpr double kModesReadNoiseE = 5.0;

struct ModeCase {
  int subapertures = 19;  ///< 19, 37 or 61
  int charge = 1;
  int modes = 18;  ///< j = 1 to this
  Budget budget = Budget::peak;
};

/// Errors for a flat wavefront: root sum square over all modes but the tilts, waves.
struct ModeErrors {
  double bound = kUnknown;               ///< Cramer-Rao bound of all pixels of the image
  Mean shapes;                           ///< measured, by templates of every spot
  double shapes_expected = kUnknown;     ///< from their covariance
  Mean positions;                        ///< measured, by the same pixels' positions only
  double positions_expected = kUnknown;  ///< NaN: positions do not determine the modes
};

/// Measures `images` noisy images. Thread-safe; the same seed gives the same numbers.
ModeErrors measure_modes(const ModeCase& one, int images, std::uint64_t seed);

}  // namespace ovws::study
