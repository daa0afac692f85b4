#include "daemon/ovwsd/procedures/saturation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ovws {
namespace {

bool is_saturated(const Image<float>& image, int x, int y) {
  return x >= 0 && y >= 0 && x < image.width && y < image.height && !std::isfinite(image.at(x, y));
}

/// Whether none of the eight pixels around this one is saturated.
bool is_alone(const Image<float>& image, int x, int y) {
  for (int k = 0; k < 9; ++k) {
    if (k != 4 && is_saturated(image, x + k % 3 - 1, y + k / 3 - 1)) return false;
  }
  return true;
}

/// Marks the pixels within `reach` of this one, from its row on.
void mark_below(Image<std::uint8_t>& image, int x, int y, int reach) {
  for (int row = y; row <= std::min(y + reach, image.height - 1); ++row) {
    const int across = int(std::sqrt(double(reach * reach - (row - y) * (row - y))));
    for (int i = std::max(0, x - across); i <= std::min(x + across, image.width - 1); ++i) {
      image.at(i, row) = 1;
    }
  }
}

}  // namespace

Error saturated_spot() {
  return {Errc::refused, "camera.exposure_us",
          "the spot is saturated: lower the exposure, the gain or the laser's power"};
}

bool is_saturated_spot(const Error& error) {
  return error.reason == saturated_spot().reason;
}

int count_saturated_spots(const Image<float>& mean_dn, double pitch_px) {
  Image<std::uint8_t> counted(mean_dn.width, mean_dn.height);
  int spots = 0;
  for (int y = 0; y < mean_dn.height; ++y) {
    for (int x = 0; x < mean_dn.width; ++x) {
      if (counted.at(x, y) != 0 || !is_saturated(mean_dn, x, y) || is_alone(mean_dn, x, y))
        continue;
      mark_below(counted, x, y, std::max(1, int(0.65 * pitch_px)));
      ++spots;
    }
  }
  return spots;
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
