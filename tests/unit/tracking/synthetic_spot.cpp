#include "tests/unit/tracking/synthetic_spot.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

namespace ovws::test {
namespace {

constexpr int kAcross = 56;  // samples across the aperture; even: none falls on the singularity
using Complex = std::complex<double>;

double aperture_coordinate(int k) {
  return (2.0 * k + 1.0) / kAcross - 1.0;
}

/// exp(-2 pi i u x) for every pixel and aperture sample: u in pixels from the spot's centre.
std::vector<Complex> waves_along(int pixels, double centre, double lambda_d_px) {
  std::vector<Complex> e;
  for (int p = 0; p < pixels; ++p) {
    for (int k = 0; k < kAcross; ++k) {
      const double cycles = 0.5 * aperture_coordinate(k) * (p - centre) / lambda_d_px;
      e.push_back(std::polar(1.0, -2.0 * std::numbers::pi * cycles));
    }
  }
  return e;
}

}  // namespace

SpotImage::SpotImage(int w, int h) : width(w), height(h), light(w, h, 0.0F) {}

void SpotImage::add(int charge, Vec2 at, double peak_dn,
                    const std::function<double(double, double)>& waves) {
  const auto ex = waves_along(width, at.x, lambda_d_px);
  const auto ey = waves_along(height, at.y, lambda_d_px);
  std::vector<Complex> rows(std::size_t(kAcross) * width);  // summed over x already
  for (int j = 0; j < kAcross; ++j) {
    for (int i = 0; i < kAcross; ++i) {
      const double x = aperture_coordinate(i), y = aperture_coordinate(j);
      if (x * x + y * y > 1.0) continue;
      const double phase = waves ? waves(x, y) : 0.0;
      const Complex field =
          std::polar(1.0, 2.0 * std::numbers::pi * phase + charge * std::atan2(y, x));
      for (int p = 0; p < width; ++p) rows[j * width + p] += field * ex[p * kAcross + i];
    }
  }
  std::vector<double> intensity(std::size_t(width) * height);
  for (int q = 0; q < height; ++q) {
    for (int p = 0; p < width; ++p) {
      Complex sum = 0.0;
      for (int j = 0; j < kAcross; ++j) sum += rows[j * width + p] * ey[q * kAcross + j];
      intensity[q * width + p] = std::norm(sum);
    }
  }
  const double scale = peak_dn / *std::max_element(intensity.begin(), intensity.end());
  for (std::size_t k = 0; k < intensity.size(); ++k) {
    light.pixels[k] += float(scale * intensity[k]);
  }
}

Image<std::uint8_t> SpotImage::mono8() const {
  return noisy8(0.0, 0);
}

Image<std::uint8_t> SpotImage::noisy8(double rms_dn, unsigned seed) const {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  Image<std::uint8_t> out(width, height);
  for (std::size_t k = 0; k < out.pixels.size(); ++k) {
    const double dn = double(light.pixels[k]) + pedestal_dn + rms_dn * noise(random);
    out.pixels[k] = std::uint8_t(std::clamp(std::round(dn), 0.0, 255.0));
  }
  return out;
}

Image<std::uint16_t> SpotImage::mono16(double gain, int full) const {
  Image<std::uint16_t> out(width, height);
  for (std::size_t k = 0; k < out.pixels.size(); ++k) {
    const double dn = gain * (double(light.pixels[k]) + pedestal_dn);
    out.pixels[k] = std::uint16_t(std::clamp(std::round(dn), 0.0, double(full)));
  }
  return out;
}

std::function<double(double, double)> tilt(Vec2 px, double lambda_d_px) {
  return [=](double x, double y) { return 0.5 * (px.x * x + px.y * y) / lambda_d_px; };
}

}  // namespace ovws::test
