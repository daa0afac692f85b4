/// Errors of many modes from one simulated bench: by the Cramer-Rao bound, by the shapes of the
/// spots, and by their positions.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/ovws/study/sensor.hpp"

namespace ovws::study {

constexpr double kPhotonsE = 19 * 20'000.0;  ///< of all spots together, at equal photons
constexpr double kModesReadNoiseE = 5.0;

/// What the summary of a study of modes says beside its rows.
nlohmann::json head_of_modes(const std::string& study);

/// Measures the errors of the modes j = 1 to `modes` for a flat wavefront in `images` noisy images
/// of the sensor `geometry` with its charges and its mask, as columns of a table: root sum square
/// over all modes but the tilts, waves. Null: the spots do not determine the modes. The same seed
/// gives the same numbers.
///
///     bound_waves               Cramer-Rao bound from all pixels of the image
///     shapes_…, positions_…     with templates of every spot; with the positions of the same spots
///     …_waves, …_standard_error_waves, …_expected_waves   the latter from the covariance
///     images                    number of images
nlohmann::json measure_modes(const Geometry& geometry, Light light, int modes, int images,
                             std::uint64_t seed);

}  // namespace ovws::study
