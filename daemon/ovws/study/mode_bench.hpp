/// Errors of many modes from one simulated bench: by the Cramer-Rao bound, by the shapes of the
/// spots, and by their positions.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "daemon/ovws/study/sensor.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {

/// Normalisation of the light at which lattices and charges are compared.
enum class Budget {
  peak,    ///< kPeakE in the brightest pixel: the camera's full well is the limit
  photons  ///< kPhotonsE in all spots together: the laser is the limit
};
constexpr std::array<Budget, 2> kBudgets{Budget::peak, Budget::photons};
const char* name_of(Budget budget);

constexpr double kPhotonsE = 19 * 20'000.0;
constexpr double kModesReadNoiseE = 5.0;

/// Errors for a flat wavefront: root sum square over all modes but the tilts, waves.
struct ModeErrors {
  double bound = kUnknown;               ///< Cramer-Rao bound from all pixels of the image
  Mean shapes;                           ///< measured with templates of every spot
  double shapes_expected = kUnknown;     ///< expected error of `shapes`, from the covariance
  Mean positions;                        ///< measured with the positions of the same spots only
  double positions_expected = kUnknown;  ///< expected; NaN: positions do not determine the modes
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ModeErrors, bound, shapes, shapes_expected, positions,
                                   positions_expected)

/// Measures the errors of the modes j = 1 to `modes` in `images` noisy images of the sensor
/// `geometry` with its charges and its mask. The same seed gives the same numbers.
ModeErrors measure_modes(const Geometry& geometry, Budget budget, int modes, int images,
                         std::uint64_t seed);

}  // namespace ovws::study
