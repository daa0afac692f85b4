/// A camera that sends fewer frames than it is set to: when it counts as slow, and what limits it.
#pragma once

#include <string>

namespace ovws {

/// `measured_hz`: frames grabbed in about a second (`rates.grabbed_hz` of the status), of which two
/// may be missing by chance. False without frames, which is another fault.
inline bool is_slow(double measured_hz, double set_hz) {
  constexpr double kUsualShare = 0.9, kByChanceHz = 2.0;
  return measured_hz > 0.0 && measured_hz < kUsualShare * set_hz - kByChanceHz;
}

/// Whether the exposure fills the time between the frames that come.
inline bool is_slowed_by_exposure(double measured_hz, double exposure_us) {
  constexpr double kLeastShare = 0.8;
  return 1e-6 * exposure_us * measured_hz >= kLeastShare;
}

/// What limits the rate of a slow camera, as far as it is known, and what to do; `examine`: how to
/// examine the bench, in the reader's words.
inline std::string slow_advice(double measured_hz, double exposure_us, const std::string& examine) {
  if (is_slowed_by_exposure(measured_hz, exposure_us)) {
    return "the exposure fills the time between frames: shorten it, or lower the frame rate";
  }
  return "the exposure leaves time for more: check the camera's link and limits (" + examine +
         "), or lower the frame rate";
}

}  // namespace ovws
