/// Phase masks of subapertures: what they imprint besides their gratings and vortices.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/zernike.hpp"

namespace ovws {

constexpr int kMinMaskPx = 16, kMaxMaskPx = 2048;  ///< side of a mask's map, pixels
constexpr std::size_t kMaxMasks = 64;
constexpr std::size_t kMaxMaskModes = 45;  ///< of all masks of one subaperture
/// Pixels of all maps: 64 MiB.
constexpr std::size_t kMaxMaskPixels = std::size_t(4) * kMaxMaskPx * kMaxMaskPx;

/// Phase mask of subapertures, the same for all that have it: the sum of its parts, waves.
struct MaskConfig {
  std::vector<int> subapertures;    ///< that have it, in the order of make_lattice; empty: all
  std::vector<Mode> modes;          ///< Zernike modes over the subaperture, RMS-normalised
  double axicon_waves = 0.0;        ///< RMS of a cone: phase proportional to the radius
  std::optional<std::string> file;  ///< names `map`
  std::string sha256;               ///< checksum of the map (float32); empty: not known
  std::shared_ptr<const Image<float>>
      map;  ///< over the square around a subaperture, waves; null: not read

  /// Whether both imprint the same phase. Files are compared by checksum, not by name.
  friend bool operator==(const MaskConfig& a, const MaskConfig& b) {
    return a.subapertures == b.subapertures && a.modes == b.modes &&
           a.axicon_waves == b.axicon_waves && a.file.has_value() == b.file.has_value() &&
           a.sha256 == b.sha256;
  }
};

/// A sensor's masks. Each subaperture has the sum of those that name it.
using Masks = std::vector<MaskConfig>;

/// Whether this subaperture has the mask.
bool is_masked(const MaskConfig& mask, int subaperture);

/// Phase of the mask at a position in units of the subaperture's radius from its centre, waves. A
/// map gives its nearest pixel.
double mask_waves(const MaskConfig& mask, Vec2 at);
/// Sum of the masks of a subaperture at such a position, waves.
double mask_waves(const Masks& masks, int subaperture, Vec2 at);

/// Key of mask number `index` of `count`: "sensor.mask", or "sensor.mask[1]" if there are several.
std::string mask_field(std::size_t index, std::size_t count);

/// Number of pixels of the maps; a map that several masks share counts once.
std::size_t map_pixels(const Masks& masks);

/// Gives a mask that names a file, but was not read from it, the map of a mask of `from` with the
/// same file: by checksum or, if it has none, by name.
void adopt_maps(Masks& masks, const Masks& from);

/// Checks the masks of a sensor of `subapertures`. Errors (Errc::invalid, field mask_field(…)…): a
/// subaperture does not exist; a file was not read; a map is not square, too small or too large, or
/// has a value that is not finite; a mode's index or coefficient is out of range; there are more
/// than kMaxMasks, the maps have more than kMaxMaskPixels, or a subaperture more than
/// kMaxMaskModes.
Result<void> check_masks(const Masks& masks, std::size_t subapertures);

}  // namespace ovws
