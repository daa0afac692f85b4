#include "daemon/ovwsd/procedures/saturation.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace ovws {

Error saturated_spot() {
  return {Errc::refused, "camera.exposure_us",
          "the spot is saturated: lower the exposure, the gain or the laser's power"};
}

bool is_saturated_spot(const Error& error) {
  return error.reason == saturated_spot().reason;
}

int saturated_spots(const Image<float>& mean_dn, double pitch_px) {
  const double cell_px = std::max(1.0, 0.5 * pitch_px);  // neighbours of a spot's cell are its own
  std::set<std::pair<int, int>> counted;
  const auto is_counted = [&counted](int column, int row) {
    for (int k = 0; k < 9; ++k) {
      if (counted.contains({row + k / 3 - 1, column + k % 3 - 1})) return true;
    }
    return false;
  };
  for (int y = 0; y < mean_dn.height; ++y) {
    for (int x = 0; x < mean_dn.width; ++x) {
      if (std::isfinite(mean_dn.at(x, y))) continue;
      const int column = int(x / cell_px), row = int(y / cell_px);
      if (!is_counted(column, row)) counted.insert({row, column});
    }
  }
  return int(counted.size());
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
