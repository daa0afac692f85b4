/// Brightness of an image, judged for automatic exposure.
#pragma once

#include <cmath>

#include "core/base/image.hpp"
#include "core/port/camera.hpp"
#include "daemon/ovwsd/sensor/sensor_snapshot.hpp"

namespace ovws {

/// Brightness of one image, DN.
struct ExposureLook {
  double full = 0.0;       ///< full scale of the pixel format
  double brightest = 0.0;  ///< of the spots; NaN: at full scale
  double dark = 0.0;       ///< black level and stray light
  bool lit = false;        ///< the brightest pixels exceed the noise
  int saturated_pixels = 0;
  CameraSettings settings;

  bool saturated() const { return std::isnan(brightest); }
  double fraction() const { return saturated() ? 1.0 : brightest / full; }
};

/// What the image should contain.
struct ExpectedSpots {
  int count = 1;
  bool resolved = true;  ///< spots are wider than a pixel, unlike hot pixels
};

/// The spots of the pattern that the SLM shows, on the pixels `lit` that the laser reaches.
ExpectedSpots expected_spots(const SensorSnapshot& now, const SlmGeometry& slm,
                             const LitPixels& lit);

/// Evaluates a mean image in DN whose saturated pixels are NaN, taken with `settings`. `brightest`
/// is the brightness that as many pixels reach as there are spots. Pixels that are ten times as
/// bright as all their neighbours are left out if spots are resolved.
ExposureLook judge_exposure(const Image<float>& image, const ExpectedSpots& expected,
                            const CameraSettings& settings);

}  // namespace ovws
