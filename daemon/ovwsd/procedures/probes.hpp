/// Probes: single spots with a known grating, by registration and flatness.
#pragma once

#include <optional>

#include "core/optics/geometry.hpp"
#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// Measures images of probes, in the thread of one procedure.
class ProbeBench {
 public:
  /// Averages `frames` frames for each image.
  ProbeBench(Bench& bench, int frames) : bench_(bench), frames_(frames) {}

  /// Shows the probe and returns its image minus the image without a probe, DN. NaN at pixels that
  /// were saturated in a frame. Errors: those of Bench; Errc::refused, field "camera": the camera's
  /// region changed during the job.
  Result<Image<float>> light(const Probe& probe);

 private:
  Bench& bench_;
  int frames_;
  std::optional<Image<float>> without_;
};

constexpr int kMaxProbeCharge = 2;  ///< either sign
constexpr double kProbeRim = 1.5;   ///< lambda/d: a spot closer to the edge is cut off

struct ProbeSpot {
  Vec2 rough;                ///< centre of the intensity, camera pixels
  std::optional<Vec2> fine;  ///< position found by find_probe, camera pixels; none: not found
};

/// Finds the spot in an image of ProbeBench::light. None: no spot is above the noise, or the spot
/// is closer than kProbeRim to the image's edge. Errors:
/// saturated_spot().
Result<std::optional<ProbeSpot>> probe_spot(const Image<float>& light, const SpotModel& spots);

constexpr int kFirstSurfaceMode = 3;  ///< tilts (j = 1, 2) are not part of a surface

/// Checks whether the light alone can be measured. Errc::refused: no registration, or a correction
/// is active.
Result<void> can_scan(const SensorSnapshot& now);

}  // namespace ovws
