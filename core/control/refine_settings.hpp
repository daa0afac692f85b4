/// Settings of the live refinement, and their checks.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct RefineSetup {
  bool enabled = false;
  double rate_hz = 1.0;                    ///< maximum number of refined frames per second
  std::optional<double> electrons_per_dn;  ///< electrons per DN at 0 dB gain; none: unknown
  double read_noise_e = 5.0;               ///< RMS, without quantisation noise
  double black_level_dn = 0.0;
  std::optional<double> saturation_dn;  ///< from 90 % of it on pixels are ignored; none: full scale
  PixelFormat format = PixelFormat::mono8;  ///< pixel format of all values in DN

  friend bool operator==(const RefineSetup&, const RefineSetup&) = default;
};

/// Conversion of electrons to camera pixel values.
struct RefineCamera {
  double electrons_per_dn = 1.0;
  double read_noise_e = 5.0;  ///< RMS, including the rounding to whole DN
  double black_dn = 0.0;
  /// Saturation: pixels that are expected above 90 % of it are ignored.
  double saturated_dn = std::numeric_limits<double>::infinity();
};

/// Whether two refine settings give equal fits: only `enabled` and `rate_hz` may differ.
inline bool same_fit(RefineSetup a, const RefineSetup& b) {
  a.enabled = b.enabled;
  a.rate_hz = b.rate_hz;
  return a == b;
}

/// Converts the values in DN to another pixel format: each additional bit doubles the DN of a given
/// intensity. Clamps saturation and black level to the new full scale.
inline RefineSetup in_format(RefineSetup settings, PixelFormat format) {
  if (settings.format == format) return settings;
  const double factor =
      std::ldexp(1.0, significant_bits(format) - significant_bits(settings.format));
  const double full = full_scale_dn(format);
  settings.format = format;
  if (settings.electrons_per_dn) *settings.electrons_per_dn /= factor;
  if (settings.saturation_dn) {
    settings.saturation_dn = std::clamp(*settings.saturation_dn * factor, 1.0, full);
  }
  const double max_black = settings.saturation_dn.value_or(full) - 0.5;
  settings.black_level_dn = std::min(settings.black_level_dn * factor, max_black);
  return settings;
}

/// Checks that involve several settings. Errors (Errc::invalid): `field` is the setting's key.
inline Result<void> check_refine(const RefineSetup& settings) {
  if (settings.enabled && !settings.electrons_per_dn) {
    return fail(Errc::invalid, "electrons_per_dn",
                "is required to refine: set the number of electrons per DN at a gain of 0 dB");
  }
  const std::string format(pixel_format_name(settings.format));
  const double full = full_scale_dn(settings.format);
  const double saturation = settings.saturation_dn.value_or(full);
  if (saturation > full) {
    return fail(Errc::invalid, "saturation_dn",
                "must be at most " + std::to_string(int(full)) + ", the full scale of " + format);
  }
  if (!(settings.black_level_dn < saturation)) {
    return fail(Errc::invalid, "black_level_dn",
                "must be below saturation_dn (null: the full scale, " + std::to_string(int(full)) +
                    " for " + format + ")");
  }
  return {};
}

}  // namespace ovws
