/// Attempts at a design with a fixed number of subapertures across the pupil; searches the number
/// that makes a bench possible, or the changes of the bench that do.
#pragma once

#include "core/optics/lattice.hpp"
#include "daemon/ovws/design/design.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"
#include "proto/limits.hpp"

namespace ovws::design {

/// How fine a grating may be, in cycles per SLM pixel, including the slope of an aberration; at
/// most kNyquistCpp.
constexpr double kComfortableCpp = 0.25;  ///< a period of 4 SLM pixels

/// Distances of neighbouring spots, lambda/d: those of spot_layout.hpp, and the one to aim at.
inline double target_distance(int charge) {
  return 1.5 * recommended_spot_distance(charge);
}

/// A bench with a number of subapertures across, before spacing and gratings are chosen.
struct Candidate {
  Bench bench;
  Config config;    ///< without base grating, with the whole sensor as region
  SpotLayout unit;  ///< with config.sensor.spacing
  double px_per_cycle = 0.0;
  std::optional<Finding> fault;  ///< it cannot work whatever the gratings are
};

/// `shapes`: the modes need the shapes of the spots, because positions determine too few.
Candidate make_candidate(const Bench& bench, const Config& base, int across, bool shapes);

/// Diameter of the pupil: what the beam illuminates of the SLM's smaller side, SLM pixels.
double pupil_px(const Bench& bench);

/// Chooses spacing, base grating and region. The result's configuration passes check_sensor and
/// check_sees_spots. `finest_cpp`: limit of the gratings.
tl::expected<Config, Finding> attempt(const Candidate& candidate, double finest_cpp);

/// Subapertures across, unless modes are asked for or they do not work.
constexpr int kUsualAcross = 5;
/// Limits of what is designed. Odd numbers only: with an even one, half a subaperture is left free
/// at the pupil's edge.
constexpr int kLeastAcross = 3;
constexpr int kMostAcross = (limits::kSubaperturesAcross.max - 1) / 2 * 2 + 1;

/// About the largest number of modes that the shapes of the vortices may determine: 2.5 for each,
/// in a lattice with 3/4 of the square of its number across.
constexpr int most_modes_by_shapes(int across) {
  return int(2.5 * 0.75 * across * across);
}

/// Whether modes that positions do not determine may come from the shapes of the spots. With
/// `unused` the search takes milliseconds.
enum class Shapes { unused, used };

/// The configuration with the fewest subapertures that determine the modes, from kUsualAcross on:
/// by the positions of their spots, or with Shapes::used by the shapes. It prefers gratings of at
/// least four SLM pixels a period. With Shapes::used, fewer than kUsualAcross are the last resort.
/// The error is that of the first attempt whose positions determine the modes.
tl::expected<Config, Finding> find_config(const Bench& bench, const Config& base, Shapes shapes);

/// The nearest change of each part that suffices alone, or if there is none, of two parts. Each was
/// tried: find_config accepts the changed bench. `limit`: what makes it impossible. Takes up to a
/// second.
std::vector<Change> changes_that_help(const Bench& bench, const Config& base, Limit limit);

}  // namespace ovws::design
