#include "core/optics/mask.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

constexpr double kMaxMaskWaves = 10.0;

float nearest_pixel(const Image<float>& map, Vec2 at) {
  const auto pixel = [&map](double along) {
    return std::clamp(int(std::floor(0.5 * (along + 1.0) * map.width)), 0, map.width - 1);
  };
  return map.at(pixel(at.x), pixel(at.y));
}

Result<void> check_map(const Image<float>& map) {
  const auto refuse = [](const std::string& reason) {
    return fail(Errc::invalid, "sensor.mask.file", reason);
  };
  if (map.width != map.height || map.width < kMinMaskPx || map.width > kMaxMaskPx) {
    return refuse("the mask has " + std::to_string(map.width) + " x " + std::to_string(map.height) +
                  " pixels: it must be square, with " + std::to_string(kMinMaskPx) + " to " +
                  std::to_string(kMaxMaskPx) + " pixels along each side");
  }
  if (!std::all_of(map.pixels.begin(), map.pixels.end(),
                   [](float v) { return std::isfinite(v); })) {
    return refuse("the mask contains NaN or infinity: give a finite phase for every pixel");
  }
  return {};
}

}  // namespace

bool is_masked(const MaskConfig& mask, int subaperture) {
  const std::vector<int>& all = mask.subapertures;
  return all.empty() || std::find(all.begin(), all.end(), subaperture) != all.end();
}

double mask_waves(const MaskConfig& mask, Vec2 at) {
  constexpr double kMeanRadius = 2.0 / 3.0, kRmsRadius = 0.23570226039551584;  // sqrt(1 / 18)
  double waves = 0.0;
  for (const Mode& mode : mask.modes) waves += mode.waves * zernike(mode.j, at);
  if (mask.axicon_waves != 0.0) {
    waves += mask.axicon_waves * (norm(at) - kMeanRadius) / kRmsRadius;
  }
  if (mask.map) waves += double(nearest_pixel(*mask.map, at));
  return waves;
}

void adopt_map(std::optional<MaskConfig>& mask, const std::optional<MaskConfig>& from) {
  if (!mask || !mask->file || mask->map || !from || !from->map) return;
  if (mask->sha256.empty() ? *mask->file != from->file : mask->sha256 != from->sha256) return;
  mask->map = from->map;
  mask->sha256 = from->sha256;
}

Result<void> check_mask(const MaskConfig& mask) {
  for (const Mode& mode : mask.modes) {
    if (mode.j < 0 || mode.j > kMaxZernikeIndex || !(std::abs(mode.waves) <= kMaxMaskWaves)) {
      return fail(Errc::invalid, "sensor.mask.modes",
                  "mode j = " + std::to_string(mode.j) + " of " + std::to_string(mode.waves) +
                      " waves: use j = 0 to " + std::to_string(kMaxZernikeIndex) +
                      ", and at most 10 waves");
    }
  }
  if (mask.file && !mask.map) {
    return fail(Errc::invalid, "sensor.mask.file",
                *mask.file +
                    " was not read: name it in the configuration file and reload that, or "
                    "name the file that is in use");
  }
  return mask.map ? check_map(*mask.map) : Result<void>{};
}

}  // namespace ovws
