#include "daemon/ovwsd/procedures/saturation.hpp"

#include <algorithm>

namespace ovws {

Error saturated_spot() {
  return {Errc::refused, "camera.exposure_us",
          "the spot is saturated: lower the exposure, the gain or the laser's power"};
}

bool is_saturated_spot(const Error& error) {
  return error.reason == saturated_spot().reason;
}

Result<bool> change_exposure(Bench& bench, double factor) {
  const CameraSnapshot now = bench.camera();
  const double period_us = 1e6 / now.settings.frame_rate_hz;
  CameraSet change;
  change.set_clamp(true);
  change.put(&CameraSettings::exposure_us, std::min(factor * now.settings.exposure_us, period_us));
  const auto set = bench.set_camera(change);
  if (!set) return fail(set.error());
  return set->settings.exposure_us != now.settings.exposure_us;
}

}  // namespace ovws
