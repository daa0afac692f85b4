#include "core/optics/mask.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "core/base/number_text.hpp"

namespace ovws {
namespace {

constexpr double kMaxMaskWaves = 10.0;

float nearest_pixel(const Image<float>& map, Vec2 at) {
  const auto pixel = [&map](double along) {
    return std::clamp(int(std::floor(0.5 * (along + 1.0) * map.width)), 0, map.width - 1);
  };
  return map.at(pixel(at.x), pixel(at.y));
}

Result<void> check_map(const Image<float>& map, const std::string& field) {
  if (map.width != map.height || map.width < kMinMaskPx || map.width > kMaxMaskPx) {
    return fail(Errc::invalid, field,
                "the mask has " + std::to_string(map.width) + " x " + std::to_string(map.height) +
                    " pixels: it must be square, with " + std::to_string(kMinMaskPx) + " to " +
                    std::to_string(kMaxMaskPx) + " pixels along each side");
  }
  if (!std::all_of(map.pixels.begin(), map.pixels.end(),
                   [](float v) { return std::isfinite(v); })) {
    return fail(Errc::invalid, field,
                "the mask contains NaN or infinity: give a finite phase for every pixel");
  }
  return {};
}

Result<void> check_mask(const MaskConfig& mask, const std::string& field,
                        std::size_t subapertures) {
  for (const int i : mask.subapertures) {
    if (i >= 0 && std::size_t(i) < subapertures) continue;
    return fail(Errc::invalid, field + ".subapertures",
                "there is no subaperture " + std::to_string(i) + ": use 0 to " +
                    std::to_string(subapertures - 1));
  }
  for (const Mode& mode : mask.modes) {
    if (mode.j >= 0 && mode.j <= kMaxZernikeIndex && std::abs(mode.waves) <= kMaxMaskWaves) {
      continue;
    }
    return fail(Errc::invalid, field + ".modes",
                "mode j = " + std::to_string(mode.j) + " of " + with_decimals(mode.waves, 3) +
                    " waves: use j = 0 to " + std::to_string(kMaxZernikeIndex) +
                    ", and at most 10 waves");
  }
  if (mask.file && !mask.map) {
    return fail(Errc::invalid, field + ".file",
                *mask.file +
                    " was not read: name it in the configuration file and reload that, or "
                    "name the file that is in use by its absolute path, as config.get does");
  }
  return mask.map ? check_map(*mask.map, field + ".file") : Result<void>{};
}

/// Whether both name the same file: by checksum or, if the first has none, by name.
bool is_same_file(const MaskConfig& a, const MaskConfig& b) {
  return a.sha256.empty() ? a.file == b.file : a.sha256 == b.sha256;
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

double mask_waves(const Masks& masks, int subaperture, Vec2 at) {
  double waves = 0.0;
  for (const MaskConfig& mask : masks) {
    if (is_masked(mask, subaperture)) waves += mask_waves(mask, at);
  }
  return waves;
}

std::string mask_field(std::size_t index, std::size_t count) {
  return count > 1 ? "sensor.mask[" + std::to_string(index) + "]" : "sensor.mask";
}

void adopt_maps(Masks& masks, const Masks& from) {
  for (MaskConfig& mask : masks) {
    if (!mask.file || mask.map) continue;
    const auto same = std::find_if(from.begin(), from.end(), [&mask](const MaskConfig& one) {
      return one.map && is_same_file(mask, one);
    });
    if (same == from.end()) continue;
    mask.map = same->map;
    mask.sha256 = same->sha256;
  }
}

std::size_t map_pixels(const Masks& masks) {
  std::set<std::shared_ptr<const Image<float>>> maps;
  for (const MaskConfig& mask : masks) {
    if (mask.map) maps.insert(mask.map);
  }
  return std::accumulate(maps.begin(), maps.end(), std::size_t(0),
                         [](std::size_t sum, const auto& map) { return sum + map->pixels.size(); });
}

Result<void> check_masks(const Masks& masks, std::size_t subapertures) {
  if (masks.size() > kMaxMasks) {
    return fail(Errc::invalid, "sensor.mask",
                std::to_string(masks.size()) + " masks: give at most " + std::to_string(kMaxMasks));
  }
  if (map_pixels(masks) > kMaxMaskPixels) {
    return fail(Errc::invalid, "sensor.mask",
                "the files have more than " + std::to_string(kMaxMaskPixels) +
                    " pixels together: give smaller maps; each SLM pixel takes the nearest pixel");
  }
  std::vector<std::size_t> modes(subapertures);
  for (std::size_t k = 0; k < masks.size(); ++k) {
    const std::string field = mask_field(k, masks.size());
    if (auto ok = check_mask(masks[k], field, subapertures); !ok) return ok;
    for (std::size_t i = 0; i < subapertures; ++i) {
      if (masks[k].modes.empty() || !is_masked(masks[k], int(i))) continue;
      modes[i] += masks[k].modes.size();
      if (modes[i] <= kMaxMaskModes) continue;
      return fail(Errc::invalid, field + ".modes",
                  "the masks of subaperture " + std::to_string(i) + " have more than " +
                      std::to_string(kMaxMaskModes) + " modes together: combine equal ones");
    }
  }
  return {};
}

}  // namespace ovws
