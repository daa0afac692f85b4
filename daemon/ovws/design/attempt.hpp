/// One attempt at a design: a fixed number of subapertures across the pupil.
#pragma once

#include "core/optics/lattice.hpp"
#include "daemon/ovws/design/design.hpp"
#include "daemon/ovwsd/layout/spot_layout.hpp"

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

}  // namespace ovws::design
