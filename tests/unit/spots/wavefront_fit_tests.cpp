/// Templates of spots against the wavefront that made the image, and against the noise that they
/// claim.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/optics/noise.hpp"
#include "core/optics/sensor_model.hpp"
#include "core/spots/point_model.hpp"
#include "tests/support/alloc_guard.hpp"

namespace ovws {
namespace {

constexpr double kPeakE = 500.0, kReadNoiseE = 5.0, kBlackDn = 50.0;
constexpr int kImagePx = 512;
using Waves = std::vector<double>;

std::vector<int> first_modes(int count) {
  std::vector<int> modes(count);
  std::iota(modes.begin(), modes.end(), 1);
  return modes;
}

SensorConfig sensor_of(int charge) {
  SensorConfig sensor;
  sensor.charge = charge;
  return sensor;
}

class Templates : public testing::Test {
 protected:
  static SensorModel& model(int charge) {
    static std::array<std::optional<SensorModel>, 2> made;
    auto& one = made.at(charge);
    if (!one) {
      one.emplace(SensorModel::make(sensor_of(charge), {}, {}, kImagePx, kImagePx).value());
    }
    return *one;
  }
  static SpotRenderer renderer(int charge, int modes) {
    return SpotRenderer::make(sensor_of(charge), {}, {}, kImagePx, kImagePx, first_modes(modes), {})
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
                                      std::uint64_t seed) {
    Noise noise(seed, 3);
    Image<std::uint16_t> dn(light.width, light.height);
    for (std::size_t k = 0; k < dn.pixels.size(); ++k) {
      const double electrons =
          double(noise.poisson(light.pixels[k])) + read_noise_e * double(noise.normal());
      dn.pixels[k] = std::uint16_t(std::lround(std::max(0.0, electrons + kBlackDn)));
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

TEST_F(Templates, OfAFlatWavefrontAreAsExactAsTheirCovarianceSays) {
  constexpr int kImages = 12;
  const PixelNoise noise{kReadNoiseE * kReadNoiseE, 1.0};
  for (const int charge : {1, 0}) {
    for (const auto& [modes, estimates] : {std::pair{18, 4}, {27, 8}, {44, 8}}) {
      const Waves flat(modes, 0.0);
      const auto rendered = renderer(charge, modes).render(flat);
      const Image<float> electrons = light(charge, flat);
      double squares = 0.0, claims = 0.0;
      for (int k = 0; k < kImages; ++k) {
        const auto image = exposed(electrons, kReadNoiseE, unsigned(k) + 1);
        const auto step = step_from(fit_spots(view(image), rendered, noise, estimates));
        ASSERT_TRUE(step);
        squares += std::pow(error(step->waves, flat), 2) / kImages;
        claims += step->covariance.diagonal().tail(modes - 2).sum() / kImages;
      }
      const double measured = std::sqrt(squares), claimed = std::sqrt(claims);
      std::printf("  charge %d, %d modes, %d estimates: error %.5f, claimed %.5f wave\n", charge,
                  modes, estimates, measured, claimed);
      EXPECT_LT(measured, 1.2 * claimed);
      EXPECT_GT(measured, 0.8 * claimed);
    }
  }
}

TEST_F(Templates, TheNoiseIsFoundFromTwoImages) {
  const Waves flat(18, 0.0);
  const auto rendered = renderer(1, 18).render(flat);
  const Image<float> electrons = light(1, flat);
  const auto a = exposed(electrons, kReadNoiseE, 1), b = exposed(electrons, kReadNoiseE, 2);
  const PixelNoise noise = noise_of(std::vector{view(a), view(b)}, rendered);
  EXPECT_NEAR(noise.per_dn, 1.0, 0.1);
  EXPECT_NEAR(noise.constant_dn2, kReadNoiseE * kReadNoiseE, 4.0);
}

/// Templates about what the tracker knows, as in the daemon.
TEST_F(Templates, FindTheWavefrontFromARoughStart) {
  const Waves flat(18, 0.0);
  const auto reference = exposed(light(1, flat, 2000.0), kReadNoiseE, 9);
  PointModel points(renderer(1, 18), 8);
  ASSERT_TRUE(points.use_reference(view(reference), {25.0, 1.0}, random(18, 0.02, 7), {}));
  for (const double rms : {0.1, 0.3, 0.6, 0.9}) {
    const Waves truth = random(18, rms, 5), off = random(18, 0.04, 6);
    Waves start = truth;
    for (std::size_t k = 0; k < start.size(); ++k) start[k] += off[k];
    const Image<float> electrons = light(1, truth, 2000.0);
    const auto image = exposed(electrons, kReadNoiseE, 1),
               other = exposed(electrons, kReadNoiseE, 2);
    const auto fit = points.templates(std::vector{view(other), view(image)}, start, {}, 4);
    ASSERT_TRUE(fit) << rms << " wave: " << fit.error().reason;
    const Frame frame = measured(**fit, view(image));
    double claimed = 0.0;
    for (std::size_t k = 2; k < 18; ++k) claimed += double(frame.sigma[k] * frame.sigma[k]);
    std::printf("  %.1f wave: error %.5f, claimed %.5f wave, drift %.4f, residual %.2f, %d lost\n",
                rms, error(frame.waves, truth), std::sqrt(claimed), frame.fitted.drift_waves,
                frame.fitted.residual, frame.fitted.lost);
    EXPECT_TRUE(frame.fitted.credible);
    EXPECT_EQ(frame.fitted.lost, 0);
    EXPECT_EQ(frame.allocations, 0U);
    EXPECT_LT(error(frame.waves, truth), 0.003);
  }
}

TEST_F(Templates, DoNotDescribeAnotherWavefront) {
  const Waves flat(18, 0.0);
  const auto image = exposed(light(1, flat), kReadNoiseE, 1);
  PointModel points(renderer(1, 18), 8);
  ASSERT_TRUE(points.use_reference(view(image), {25.0, 1.0}, flat, {}));
  const auto other = exposed(light(1, flat), kReadNoiseE, 2);
  const auto fit = points.templates(std::vector{view(other), view(image)}, flat, {}, 4);
  ASSERT_TRUE(fit) << fit.error().reason;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Waves truth = random(18, 0.5, seed);
    const auto changed = exposed(light(1, truth), kReadNoiseE, seed);
    const Frame frame = measured(**fit, view(changed));
    EXPECT_FALSE(frame.fitted.credible) << "seed " << seed;
    EXPECT_EQ(frame.allocations, 0U);
  }
}

/// In bright light, too: another wavefront may agree with 16 spots of 19.
TEST_F(Templates, AreNotConfirmedByAFrameWithoutThreeSpotsOfNineteen) {
  const Waves flat(18, 0.0);
  const auto reference = exposed(light(1, flat, 2000.0), kReadNoiseE, 1);
  PointModel points(renderer(1, 18), 8);
  ASSERT_TRUE(points.use_reference(view(reference), {25.0, 1.0}, flat, {}));
  auto image = exposed(light(1, flat, 2000.0), kReadNoiseE, 2);
  const auto fit = points.templates(std::vector{view(reference), view(image)}, flat, {}, 4);
  ASSERT_TRUE(fit) << fit.error().reason;
  for (int lost = 1; lost <= 3; ++lost) {
    const PixelBox box = (*fit)->spots().spots()[std::size_t(lost)].window.pixels();
    for (int y = box.y; y < box.y + box.height; ++y) {
      std::fill_n(&image.at(box.x, y), box.width, std::uint16_t(kBlackDn));
    }
    const auto again = points.templates(std::vector{view(reference), view(image)}, flat, {}, 4);
    EXPECT_EQ(again.has_value(), lost <= 2) << lost << " spots lost";
  }
}

}  // namespace
}  // namespace ovws
