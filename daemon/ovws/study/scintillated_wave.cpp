#include "daemon/ovws/study/scintillated_wave.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <unsupported/Eigen/FFT>

namespace ovws::study {
namespace {

constexpr double kPi = std::numbers::pi;

/// Fourier transform of all rows and columns; the inverse with its factor 1 / N^2.
void transform(Wave& wave, bool inverse) {
  Eigen::FFT<float> fft;
  std::vector<std::complex<float>> line(kWavePx), out(kWavePx);
  const auto run = [&](int first, int stride) {
    for (int k = 0; k < kWavePx; ++k)
      line[std::size_t(k)] = wave.pixels[std::size_t(first + k * stride)];
    if (inverse) {
      fft.inv(out, line);
    } else {
      fft.fwd(out, line);
    }
    for (int k = 0; k < kWavePx; ++k)
      wave.pixels[std::size_t(first + k * stride)] = out[std::size_t(k)];
  };
  for (int row = 0; row < kWavePx; ++row) run(row * kWavePx, 1);
  for (int column = 0; column < kWavePx; ++column) run(column, kWavePx);
}

/// Multiplies by `gain(f^2)`, f in cycles per pixel.
template <class Gain>
void filter(Wave& spectrum, const Gain& gain) {
  const auto frequency = [](int k) {
    return double(k < kWavePx / 2 ? k : k - kWavePx) / double(kWavePx);
  };
  for (int y = 0; y < kWavePx; ++y) {
    for (int x = 0; x < kWavePx; ++x) {
      const double fx = frequency(x), fy = frequency(y);
      spectrum.pixels[std::size_t(y * kWavePx + x)] *= gain(fx * fx + fy * fy);
    }
  }
}

/// exp(i phase) of the layer. White noise is filtered by the root of the spectrum.
Wave layer(double r0_px, std::uint64_t seed) {
  Wave wave(kWavePx, kWavePx);
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  for (auto& pixel : wave.pixels) {
    const float real = normal(random);
    pixel = {real, normal(random)};
  }
  const double outer = 1.0 / (kOuterScale * kPupilPx * kOuterScale * kPupilPx);
  filter(wave, [&](double f2) {
    const double power = 0.0229 * std::pow(r0_px, -5.0 / 3.0) * std::pow(f2 + outer, -11.0 / 6.0);
    return f2 > 0.0 ? float(std::sqrt(power) * kWavePx) : 0.0F;  // times N^2 df, df = 1 / N
  });
  transform(wave, true);
  for (auto& pixel : wave.pixels) pixel = std::polar(1.0F, pixel.real());
  return wave;
}

}  // namespace

Wave scintillated_wave(const Air& air, std::uint64_t seed) {
  const double r0_px = kPupilPx / air.pupils_per_r0;
  Wave wave = layer(r0_px, seed);
  if (air.rytov_variance <= 0.0) return wave;
  const double fresnel_px = r0_px * std::pow(air.rytov_variance / 1.145, 0.6);
  transform(wave, false);
  filter(wave, [&](double f2) {
    return std::polar(1.0F, float(std::remainder(-kPi * fresnel_px * fresnel_px * f2, 2.0 * kPi)));
  });
  transform(wave, true);
  return wave;
}

std::vector<PupilPixel> pupil_pixels() {
  std::vector<PupilPixel> pixels;
  constexpr double kCentre = 0.5 * (kWavePx - 1);
  for (int y = 0; y < kWavePx; y += 2) {
    for (int x = 0; x < kWavePx; x += 2) {
      const Vec2 at = (2.0 / kPupilPx) * Vec2{x - kCentre, y - kCentre};
      if (norm(at) <= 1.0) pixels.push_back({x, y, at});
    }
  }
  return pixels;
}

double scintillation_index(const Wave& wave) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const PupilPixel& pixel : pupil_pixels()) {
    const double intensity = std::norm(wave.pixels[std::size_t(pixel.y * kWavePx + pixel.x)]);
    sum += intensity;
    squares += intensity * intensity;
    ++count;
  }
  return squares * count / (sum * sum) - 1.0;
}

}  // namespace ovws::study
