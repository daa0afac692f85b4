/// Phase mask of a subaperture: what it imprints besides its grating and its vortex.
#pragma once

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

/// Whether this subaperture has the mask.
bool is_masked(const MaskConfig& mask, int subaperture);

/// Phase of the mask at a position in units of the subaperture's radius from its centre, waves. A
/// map gives its nearest pixel.
double mask_waves(const MaskConfig& mask, Vec2 at);

/// Gives a mask that names a file, but was not read from it, the map of `from`, if that is the same
/// file: by checksum or, if `mask` has none, by name.
void adopt_map(std::optional<MaskConfig>& mask, const std::optional<MaskConfig>& from);

/// Checks the mask. Errors (Errc::invalid, field "sensor.mask…"): the file was not read; the map
/// is not square, too small or too large, or has a value that is not finite; a mode's index or
/// coefficient is out of range.
Result<void> check_mask(const MaskConfig& mask);

}  // namespace ovws
