/// Lone spots of known slopes on the bench: what registration and flatness look at.
#pragma once

#include <optional>

#include "core/tracking/tracker.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// For the thread of one procedure.
class ProbeBench {
 public:
  /// `frames` are averaged for each picture.
  ProbeBench(Bench& bench, int frames) : bench_(bench), frames_(frames) {}

  /// Shows the probe and returns its light, DN: with it less without, NaN where it is saturated.
  /// Errors: those of Bench; Errc::refused, "camera" if its region changed meanwhile.
  Result<Image<float>> light(const Probe& probe);

 private:
  Bench& bench_;
  int frames_;
  std::optional<Image<float>> without_;
};

struct ProbeSpot {
  Vec2 rough;                ///< the middle of the light, camera pixels
  std::optional<Vec2> fine;  ///< by the matched filter, if that finds it
};

/// The one spot of such a light; none if nothing stands out of the noise, or nearer than 1.5
/// lambda/d to the picture's rim. Errors (Errc::refused, "camera.exposure_us"): it is saturated.
Result<std::optional<ProbeSpot>> probe_spot(const Image<float>& light, const SpotModel& spots);

}  // namespace ovws
