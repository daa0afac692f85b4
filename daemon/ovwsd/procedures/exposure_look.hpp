/// Brightness of an image, judged for automatic exposure.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/port/camera.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// Brightness of one image, DN.
struct ExposureLook {
  double full = 0.0;            ///< full scale of the pixel format
  double brightest = 0.0;       ///< of the spots' brightest pixels; NaN: at full scale
  double dark = 0.0;            ///< black level and stray light
  std::optional<double> top{};  ///< of the brightest spot; NaN: at full scale; none: unknown
  bool lit = false;             ///< at least one peak exceeds the noise
  bool certain = false;         ///< enough of them to be the spots, and not a zeroth order alone
  int saturated_pixels = 0;
  CameraSettings settings;

  bool mostly_saturated() const { return std::isnan(brightest); }
  bool saturated() const { return mostly_saturated() || (top && std::isnan(*top)); }
  double fraction() const { return mostly_saturated() ? 1.0 : brightest / full; }
};

/// What the image should contain.
struct ExpectedSpots {
  int count = 1;
  double size_px = 1.0;          ///< lambda/d of a spot, in the pixels that the laser reaches
  double apart_px = 1.0;         ///< between two spots, at least
  std::vector<Vec2> found_px{};  ///< where the tracker finds spots, in the same pixels
};

/// The spots of the pattern that the SLM shows, on the pixels `lit` that the laser reaches. Errors:
/// those of make_lattice.
Result<ExpectedSpots> expected_spots(const SensorSnapshot& now, const SlmGeometry& slm,
                                     const LitPixels& lit);

/// Evaluates a mean image in DN whose saturated pixels are NaN, taken with `settings`. `brightest`
/// is the 80th percentile of the brightest pixels of the spots: those peaks, as far apart as spots
/// are, that are many and about equally bright. A zeroth order in view with its side lobes does not
/// count, nor do spots outside the image, as long as three tenths of the spots, and six, are
/// inside. If the tracker finds at least half of the spots, the pixels around these count instead,
/// and `top` is known. Pixels that are ten times as bright as all their neighbours are left out,
/// unless spots are about as small as a pixel.
ExposureLook judge_exposure(const Image<float>& image, const ExpectedSpots& expected,
                            const CameraSettings& settings);

}  // namespace ovws
