/// How much room the camera's region, the gratings and the zeroth order leave for the spots.
#pragma once

#include <algorithm>

#include "daemon/ovws/design/attempt.hpp"

namespace ovws::design {

/// The largest distance of neighbouring spots, lambda/d, that each limit allows.
struct Room {
  double by_region = 0.0;
  double by_grating = 0.0;  ///< if the zeroth order need not be outside the region
  double by_orders = 0.0;   ///< with the zeroth order outside the region
};

/// `finest_cpp`: limit of the gratings.
Room room_of(const Candidate& of, double finest_cpp);

/// What it means that neighbouring spots cannot have the recommended distance.
Finding too_little_room(const Candidate& of, const Room& room);

/// Lengths of a candidate in cycles per SLM pixel.
struct Cycles {
  Vec2 reach_per_distance;  ///< of the farthest spot, for a distance of neighbours of 1 lambda/d
  double lambda_d = 0.0;
  double margin = 0.0;
  double to_zeroth = 0.0;  ///< from the farthest spot to the zeroth order, at least

  explicit Cycles(const Candidate& of)
      : reach_per_distance((1.0 / of.px_per_cycle / of.unit.nearest) * of.unit.reach_px),
        lambda_d(of.unit.lambda_d_px / of.px_per_cycle),
        margin(of.unit.margin_px / of.px_per_cycle),
        to_zeroth(
            std::max(margin + lambda_d + 0.5 * kRegionStep / of.px_per_cycle,
                     lambda_d * min_zeroth_distance(of.unit.spots_px.size(), of.bench.charge))) {}
  Vec2 reach(double distance) const { return distance * reach_per_distance; }
  /// Slope of an aberration that moves a spot halfway to its neighbour.
  double headroom(double distance) const { return 0.5 * distance * lambda_d; }
};

}  // namespace ovws::design
