/// Images of single spots with known positions, by a direct Fourier sum over the aperture.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"

namespace ovws::test {

constexpr double kLambdaD = 12.55;  // camera pixels

struct SpotImage {
  int width = 128, height = 120;
  double lambda_d_px = kLambdaD;
  double pedestal_dn = 0.0;
  Image<float> light;  ///< mean DN, without the pedestal

  explicit SpotImage(int w = 128, int h = 120);
  /// Adds the far field of a circular aperture of charge l, centred on `at`, its brightest pixel
  /// `peak_dn`. `waves(x, y)`: phase over the aperture, coordinates in units of its radius.
  void add(int charge, Vec2 at, double peak_dn,
           const std::function<double(double, double)>& waves = {});

  Image<std::uint8_t> mono8() const;
  /// With Gaussian noise of this RMS, reproducible for a seed.
  Image<std::uint8_t> noisy8(double rms_dn, unsigned seed) const;
  /// Scaled by `gain` before rounding, clipped at `full`.
  Image<std::uint16_t> mono16(double gain, int full) const;
};

/// The phase (waves, aperture coordinates) that moves a spot by `px` camera pixels.
std::function<double(double, double)> tilt(Vec2 px, double lambda_d_px);

}  // namespace ovws::test
