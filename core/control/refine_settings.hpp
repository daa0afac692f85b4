/// What the live refinement is told, as data.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/base/image.hpp"
#include "core/base/result.hpp"

namespace ovws {

struct RefineSettings {
  bool enabled = false;
  double rate_hz = 1.0;                    ///< at most so many frames a second are refined
  std::optional<double> electrons_per_dn;  ///< at a gain of 0 dB; none: not known
  double read_noise_e = 5.0;               ///< RMS, without the rounding to whole DN
  double black_level_dn = 0.0;
  std::optional<double> saturation_dn;  ///< from here on not counted; none: the format's full scale
  PixelFormat format = PixelFormat::mono8;  ///< whose DN these are

  friend bool operator==(const RefineSettings&, const RefineSettings&) = default;
};

/// Whether both say the same of the camera.
inline bool same_camera(RefineSettings a, const RefineSettings& b) {
  a.enabled = b.enabled;
  a.rate_hz = b.rate_hz;
  return a == b;
}

/// The same camera's numbers in DN of another format: of two formats, the one with a bit more tells
/// the same light by twice the number.
inline RefineSettings in_format(RefineSettings settings, PixelFormat format) {
  if (settings.format == format) return settings;
  const double factor =
      std::ldexp(1.0, significant_bits(format) - significant_bits(settings.format));
  const double full = full_scale_dn(format);
  settings.format = format;
  if (settings.electrons_per_dn) *settings.electrons_per_dn /= factor;
  if (settings.saturation_dn) {
    settings.saturation_dn = std::clamp(*settings.saturation_dn * factor, 1.0, full);
  }
  const double most_black = settings.saturation_dn.value_or(full) - 0.5;
  settings.black_level_dn = std::min(settings.black_level_dn * factor, most_black);
  return settings;
}

/// Errc::refused (field enabled) for what cannot be refined in this camera's format.
inline Result<void> check_refinable(const RefineSettings& settings) {
  if (!settings.enabled || traits_of(settings.format).filter == ColourFilter::none) return {};
  return fail(Errc::refused, "enabled",
              "the camera's " + std::string(pixel_format_name(settings.format)) +
                  " cannot be refined: the model knows no colour filters; set the camera's "
                  "pixel_format to a Mono one first");
}

/// Errors (Errc::invalid, field as the key): what each number alone does not show.
inline Result<void> check_refine(const RefineSettings& settings) {
  if (settings.enabled && !settings.electrons_per_dn) {
    return fail(Errc::invalid, "electrons_per_dn",
                "must be known to refine: state how many electrons make one DN at a gain of 0 dB");
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
                "must be below saturation_dn, which is null for the full scale, " +
                    std::to_string(int(full)) + " for " + format);
  }
  return {};
}

}  // namespace ovws
