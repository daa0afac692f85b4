/// Diffractive operator: the interaction matrix from modes poked in the diffraction model.
#pragma once

#include <functional>
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

/// Diffractive operator by central differences: propagates each mode of `slopes` at
/// +-kDiffractiveStep through the noise-free model and tracks the spots. The tracker starts at
/// `spots_px` (flat wavefront) plus the displacements that `slopes` predicts. A spot that is not
/// found in every image, for example outside the camera's image, has the flat position NaN and rows
/// of 0. Z modes take 2 Z + 1 propagations: 0.3 s for 18 modes of the default bench, some seconds
/// for 91 spots. Not for the frame path.
///
/// The operator is exact for aberrations of about the step. For larger aberrations the slopes
/// operator is better: aberration inside a subaperture changes the spot's shape. The tracked
/// position then changes by a term that is cubic in the waves, even for isolated spots. No linear
/// matrix measures 0.3 wave of a mode of n >= 3 to 0.005 wave. The derivatives of a SpotRenderer
/// cannot replace the operator: they omit the light of distant subapertures, which moves a spot as
/// much as the slopes operator errs.
///
/// Errors, field "tracking": Errc::refused if the tracker finds fewer than 3 spots, or if the found
/// spots do not determine every mode of `slopes`; Errc::unavailable after `limit_s` seconds.
Result<ModeOperator> diffractive_operator(
    SensorField& field, const std::function<const SpotTracker&(int spot)>& tracker_of,
    const ModeOperator& slopes, std::span<const Vec2> spots_px,
    double limit_s = std::numeric_limits<double>::infinity());
/// The same with one tracker for all spots.
Result<ModeOperator> diffractive_operator(SensorField& field, const SpotTracker& tracker,
                                          const ModeOperator& slopes,
                                          std::span<const Vec2> spots_px,
                                          double limit_s = std::numeric_limits<double>::infinity());

}  // namespace ovws
