/// Where the camera sees which slope, measured: known slopes are shown, and the spot is found.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/geometry.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// A lone spot that was shown with a known slope.
struct ProbeSight {
  Vec2 offset_cpp;  ///< from the base subaperture's grating, cycles per SLM pixel
  Vec2 at_px;       ///< where it was found
};

/// at = base_px + px_per_cycle * offset.
struct Registration {
  Vec2 base_cpp;  ///< the grating of the base subaperture that base_px is of
  PxPerCycle px_per_cycle;
  Vec2 base_px;
  /// One standard error of each number, from what the map leaves of the sights.
  PxPerCycle standard_error;
  Vec2 base_standard_error_px;
  double residual_px = 0.0;  ///< RMS over x and y of what the map leaves
  int sights = 0;
  std::int64_t t_taken_ns = 0;  ///< UNIX epoch UTC; 0: not said
};

/// The same map, its base that of another grating.
Registration rebased(const Registration& registration, Vec2 base_cpp);

/// By least squares. Errors (Errc::refused): fewer than 4 sights, or all nearly on one line.
Result<Registration> fit_registration(std::span<const ProbeSight> sights);

/// The one spot of `light`, a mean picture minus the same without the spot (DN, NaN where nothing
/// is known); none if nothing stands out of the noise. `spots` tells charge and size, which may be
/// wrong by a third. To within a fraction of lambda/d: a start for find_probe.
std::optional<Vec2> spot_in(const Image<float>& light, const SpotModel& spots);

/// The same place to the precision of the matched filter, begun at `start_px`; none if it does not
/// find the spot there.
std::optional<Vec2> find_probe(const Image<float>& light, const SpotModel& spots, Vec2 start_px);

}  // namespace ovws
