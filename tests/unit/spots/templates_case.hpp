/// Images of a sensor by its diffraction model, and what templates measure of them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "core/optics/noise.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/spots/point_model.hpp"
#include "tests/support/alloc_guard.hpp"

namespace ovws {

constexpr double kPeakE = 500.0, kReadNoiseE = 5.0, kBlackDn = 50.0;
constexpr int kImagePx = 512;
using Waves = std::vector<double>;

inline std::vector<int> first_modes(int count) {
  std::vector<int> modes(count);
  std::iota(modes.begin(), modes.end(), 1);
  return modes;
}

inline SensorConfig sensor_of(int charge) {
  SensorConfig sensor;
  sensor.charge = charge;
  return sensor;
}

class Templates : public testing::Test {
 public:
  static SensorModel& model(int charge) {
    static std::array<std::optional<SensorModel>, 3> made;
    auto& one = made.at(charge);
    if (!one) {
      one.emplace(SensorModel::make(sensor_of(charge), {}, {}, kImagePx, kImagePx).value());
    }
    return *one;
  }
  /// `half_width` of the windows, lambda/d.
  static SpotRenderer renderer(int charge, int modes, double half_width = 2.0,
                               const LitPixels& lit = {}) {
    return SpotRenderer::make(sensor_of(charge), {}, {}, kImagePx, kImagePx, first_modes(modes),
                              {.half_width = half_width, .lit = lit})
        .value();
  }
  /// Electrons.
  static Image<float> light(int charge, const Waves& waves, double peak_e = kPeakE) {
    std::vector<Mode> modes;
    for (std::size_t k = 0; k < waves.size(); ++k) modes.push_back({int(k) + 1, waves[k]});
    Image<float> light = model(charge).intensity(modes).value();
    scale(light, peak_e / model(charge).peak_of_spots(light, modes));
    return light;
  }
  /// One electron a DN.
  static Image<std::uint16_t> exposed(const Image<float>& light, double read_noise_e,
                                      std::uint64_t seed, double black_dn = kBlackDn) {
    Noise noise(seed, 3);
    Image<std::uint16_t> dn(light.width, light.height);
    for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
      const double electrons =
          double(noise.poisson(light.pixels[k])) + read_noise_e * double(noise.normal());
      dn.pixels[k] = std::uint16_t(std::lround(std::max(0.0, electrons + black_dn)));
    }
    return dn;
  }
  static ImageView view(const Image<std::uint16_t>& image) {
    return view_of(image, PixelFormat::mono16);
  }
  static Waves random(int count, double rms, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    Waves waves(count, 0.0);
    double squares = 0.0;
    for (std::size_t k = 2; k < waves.size(); ++k) {
      waves[k] = normal(generator);
      squares += waves[k] * waves[k];
    }
    for (double& w : waves) w *= rms / std::sqrt(squares);
    return waves;
  }
  /// What the frame path does with an image.
  struct Frame {
    FittedFrame fitted;
    std::vector<float> waves, sigma;
    std::vector<SpotFix> fixes;
    std::uint64_t allocations = 0;
  };
  static Frame measured(const FrameFit& fit, const ImageView& image) {
    const std::size_t spots = fit.spots().spots().size(), modes = fit.modes_j().size();
    Frame frame{
        {}, std::vector<float>(modes), std::vector<float>(modes), std::vector<SpotFix>(spots)};
    std::vector<SpotEstimates> found(spots);
    auto pixels = fit.spots().make_scratch();
    auto solve = fit.make_scratch();
    const test::AllocGuard guard;
    for (std::size_t i = 0; i < spots; ++i) found[i] = fit.spots().fit(image, i, pixels);
    frame.fitted = fit.solve(found, solve, frame.waves, frame.sigma, frame.fixes);
    frame.allocations = guard.allocations();
    return frame;
  }
  /// RMS over j >= 3.
  template <class Found>
  static double error(const Found& found, const Waves& truth) {
    double sum = 0.0;
    for (std::size_t k = 2; k < truth.size(); ++k) {
      sum += std::pow(double(found[k]) - truth[k], 2);
    }
    return std::sqrt(sum);
  }
};

}  // namespace ovws
