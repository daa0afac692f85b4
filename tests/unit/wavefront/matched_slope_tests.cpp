/// Slope model of the matched filter (matched_tilt) against the diffraction of one subaperture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "core/optics/far_field.hpp"
#include "core/optics/zernike.hpp"
#include "core/tracking/matched.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

constexpr int kImage = 160;
constexpr double kPxPerCycle = 1928.3;
constexpr double kDiameter = 153.6;  // SLM pixels: lambda/d = 12.55 camera pixels
constexpr double kWaves = 0.03;

class OneSubaperture : public testing::TestWithParam<int> {
 protected:
  OneSubaperture()
      : far_field_(slm_, {kImage,
                          kImage,
                          {-0.5 * kImage / kPxPerCycle, -0.5 * kImage / kPxPerCycle},
                          1.0 / kPxPerCycle}),
        tracker_({GetParam(), kPxPerCycle / kDiameter}),
        scratch_(tracker_.make_scratch()) {}

  /// Intensity of the subaperture alone, brightest pixel 1; `waves` over its unit circle.
  template <class Waves>
  Image<float> light(Waves waves) {
    Image<std::complex<float>> field(slm_.width_px, slm_.height_px), far;
    for (int y = 0; y < slm_.height_px; ++y) {
      for (int x = 0; x < slm_.width_px; ++x) {
        const Vec2 at =
            (2.0 / kDiameter) * Vec2{x - 0.5 * (slm_.width_px - 1), y - 0.5 * (slm_.height_px - 1)};
        if (norm(at) > 1.0) continue;
        const double phase =
            2.0 * std::numbers::pi * waves(at) + GetParam() * std::atan2(at.y, at.x);
        field.at(x, y) = std::polar(1.0F, float(phase));
      }
    }
    far_field_.propagate(field, far);
    Image<float> image(kImage, kImage);
    float most = 0.0F;
    for (std::size_t k = 0; k < far.pixels.size(); ++k) {
      image.pixels[k] = std::norm(far.pixels[k]);
      most = std::max(most, image.pixels[k]);
    }
    for (float& pixel : image.pixels) pixel /= most;
    return image;
  }

  /// Mean fix over noisy exposures, so that the tracker's noise estimate is a realistic one.
  Vec2 found(const Image<float>& light, double peak, double read_noise) {
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    Vec2 sum;
    constexpr int kFrames = 100;
    for (int n = 0; n < kFrames; ++n) {
      Image<std::uint16_t> image(kImage, kImage);
      for (std::size_t k = 0; k < image.pixels.size(); ++k) {
        const double mean = peak * double(light.pixels[k]);
        const double noise = std::sqrt(mean + read_noise * read_noise) * normal(random);
        image.pixels[k] = std::uint16_t(std::clamp(std::round(mean + noise + 300.0), 0.0, 65535.0));
      }
      const SpotFix fix = tracker_.track(view_of(image, PixelFormat::mono16),
                                         {0.5 * kImage, 0.5 * kImage}, scratch_);
      EXPECT_TRUE(fix.found());
      sum = sum + Vec2{double(fix.x), double(fix.y)};
    }
    return (1.0 / kFrames) * sum;
  }

  double predicted(int j) const {
    SensorConfig sensor;
    sensor.pupil_diameter_px = kDiameter;
    const Lattice one{kDiameter, {{{0.0, 0.0}, {0.0, 0.0}}}};
    const std::vector<int> modes{j};
    const SlopeModel model = slope_model(GetParam(), {TrackerKind::matched, 0.3});
    return slope_matrix(one, sensor, modes, model, kPxPerCycle)(0, 0);
  }

  SlmGeometry slm_;
  FarField far_field_;
  MatchedTracker tracker_;
  TrackScratch scratch_;
};

TEST_P(OneSubaperture, MovesForComaAsTheSlopeModelSays) {
  // r^3 cos t = (coma Z(3,1) / sqrt 8 + tip Z(1,1)) / 3: its slope is no small difference, unlike
  // coma's.
  const double expected = (predicted(8) / std::sqrt(8.0) + predicted(2)) / 3.0;
  const auto coma = [](double waves) {
    return [waves](Vec2 at) { return waves * (at.x * at.x + at.y * at.y) * at.x; };
  };
  const Image<float> plus = light(coma(kWaves)), minus = light(coma(-kWaves));
  for (const double read_noise : {5.0, 25.0, 60.0, 250.0}) {  // all noise levels in turn
    const Vec2 move =
        (0.5 / kWaves) * (found(plus, 3000.0, read_noise) - found(minus, 3000.0, read_noise));
    std::printf(
        "  charge %d, read noise %3.0f e of a peak of 3000 e: %.3f px a wave of r^3 cos t, "
        "the model says %.3f (%.4f)\n",
        GetParam(), read_noise, move.x, expected, move.x / expected);
    EXPECT_NEAR(move.x, expected, 0.02 * expected);
    EXPECT_NEAR(move.y, 0.0, 0.02 * expected);
  }
}

TEST_P(OneSubaperture, MovesForATiltByItsGradient) {
  const double expected = kPxPerCycle / (0.5 * kDiameter);
  const Vec2 move = found(light([](Vec2 at) { return 0.05 * at.y; }), 30000.0, 5.0) -
                    found(light([](Vec2 at) { return -0.05 * at.y; }), 30000.0, 5.0);
  EXPECT_NEAR(move.y, 0.1 * expected, 0.002 * expected);
  EXPECT_NEAR(move.x, 0.0, 0.002 * expected);
}

TEST(MatchedTilt, OfCubicPhaseIsBetweenZTiltAndTheCentroids) {
  // r^3 cos t is 2/3 for Z-tilt and 0.6 for V-tilt. An independent one-dimensional integral of the
  // same filter gave 0.620 for charge 0, 0.682 for charge 1.
  SensorConfig sensor;
  const Lattice one{sensor.pupil_diameter_px, {{{0.0, 0.0}, {0.0, 0.0}}}};
  const std::vector<int> modes{8};
  const double px = kPxPerCycle / 384.0 * std::sqrt(8.0);
  const auto cubic = [&](int charge) {
    const SlopeModel model = slope_model(charge, {TrackerKind::matched, 0.3});
    return (slope_matrix(one, sensor, modes, model, kPxPerCycle)(0, 0) / px + 2.0) / 3.0;
  };
  EXPECT_NEAR(cubic(0), 0.620, 0.002);
  EXPECT_NEAR(cubic(1), 0.682, 0.002);
  EXPECT_NEAR(cubic(-1), cubic(1), 1e-12);
}

std::string charge_name(const testing::TestParamInfo<int>& info) {
  return info.param < 0 ? "minus_" + std::to_string(-info.param) : std::to_string(info.param);
}
INSTANTIATE_TEST_SUITE_P(Charge, OneSubaperture, testing::Values(0, 1, -1, 2), charge_name);

}  // namespace
}  // namespace ovws
