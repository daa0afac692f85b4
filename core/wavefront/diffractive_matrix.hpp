/// Diffractive operator: the interaction matrix from modes poked in the diffraction model.
#pragma once

#include <limits>
#include <span>

#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/sensor_field.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/mode_operator.hpp"

namespace ovws {

/// Step of the central differences, RMS-normalised waves.
constexpr double kDiffractiveStep = 0.05;

/// Central differences: propagates each mode of `slopes` at +-kDiffractiveStep through the
/// noise-free model and tracks the spots from where the slopes predict them, next to `spots_px`,
/// the positions for a flat wavefront. A spot that the tracker does not find in every image (for
/// example outside the camera's image) has the flat position NaN and rows of 0. 2 Z + 1
/// propagations: 0.3 s for 18 modes of the default bench, some seconds for 91 spots. Not for the
/// frame path.
///
/// It is exact for aberrations of about the step. For larger ones the slopes are better: aberration
/// inside a subaperture changes the spot's shape, and with it the tracked position, by a term that
/// is cubic in the waves. Isolated spots show the same. No linear matrix reads 0.3 wave of a mode
/// of n >= 3 to 0.005 wave. The derivatives of a SpotRenderer are no substitute: they omit distant
/// subapertures, whose light moves a spot as much as what the slopes lack.
///
/// Errors (Errc::refused, field "tracking"): the tracker finds fewer than 3 spots, the spots that
/// it finds do not determine every mode of `slopes`, or it takes longer than `limit_s` seconds.
Result<ModeOperator> diffractive_operator(SensorField& field, const SpotTracker& tracker,
                                          const ModeOperator& slopes,
                                          std::span<const Vec2> spots_px,
                                          double limit_s = std::numeric_limits<double>::infinity());

}  // namespace ovws
