/// PositionFit: exact without noise, and at the Cramer-Rao bound in noise.
#include "core/spots/position_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/wavefront/slope_model.hpp"
#include "tests/unit/tracking/noisy_spot.hpp"
#include "tests/unit/tracking/synthetic_spot.hpp"

namespace ovws {
namespace {

using test::kLambdaD;

constexpr int kPositions = 12, kRealisations = 12;
const std::vector<double> kSnr{2.0, 3.0, 4.5, 9.0, 22.0};

struct Errors {
  double sum = 0.0;
  int found = 0, tried = 0;

  void add(const SpotFix& fix, Vec2 truth) {
    ++tried;
    if (!fix.found()) return;
    ++found;
    sum += std::pow(double(fix.x) - truth.x, 2) + std::pow(double(fix.y) - truth.y, 2);
  }
  double rms() const { return std::sqrt(sum / (2.0 * found)); }
};

class PositionFitTest : public testing::TestWithParam<int> {
 protected:
  PositionFitTest()
      : spots_{GetParam(), kLambdaD},
        shape_(spots_, 8.0),
        fit_(make_position_fit(spots_).value()),
        scratch_(fit_->make_scratch()) {}

  SpotFix track(const ImageView& image, Vec2 start) { return fit_->track(image, start, scratch_); }

  SpotModel spots_;
  ModelShape shape_;
  std::unique_ptr<const SpotTracker> fit_;
  TrackScratch scratch_;
};

TEST_P(PositionFitTest, RecoversAnySubPixelPositionFromAround) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(58.0, 66.0), off(-4.0, 4.0);
  for (int k = 0; k < 25; ++k) {
    const Vec2 truth{place(random), place(random)};
    test::SpotImage picture;
    picture.add(GetParam(), truth, 200.0);
    const auto image = picture.mono16(200.0, 65535);
    const SpotFix fix =
        track(view_of(image, PixelFormat::mono16), truth + Vec2{off(random), off(random)});
    ASSERT_TRUE(fix.found());
    EXPECT_NEAR(fix.x, truth.x, 0.002);
    EXPECT_NEAR(fix.y, truth.y, 0.002);
    EXPECT_GT(fix.quality, 0.98F);
  }
}

TEST_P(PositionFitTest, ReachesTheBoundAtEverySignal) {
  for (const double snr : kSnr) {
    const double read_noise_e = test::read_noise_of(snr);
    std::mt19937 random{unsigned(10 * snr)};
    std::uniform_real_distribution<double> place(34.0, 38.0), off(-2.0, 2.0);
    Errors errors;
    for (int p = 0; p < kPositions; ++p) {
      const Vec2 truth{place(random), place(random)};
      const Image<float> mean = test::mean_electrons(shape_, truth);
      for (int k = 0; k < kRealisations; ++k) {
        const auto image = test::expose12(mean, read_noise_e, random());
        const Vec2 start = truth + Vec2{off(random), off(random)};
        errors.add(track(view_of(image, PixelFormat::mono12), start), truth);
      }
    }
    const double bound = test::bound_px(shape_, {36.2, 35.9}, read_noise_e);
    std::printf("  charge %d, SNR %4.1f: bound %.4f px, fit %.3f x (%d of %d found)\n", GetParam(),
                snr, bound, errors.rms() / bound, errors.found, errors.tried);
    EXPECT_LE(errors.rms(), 1.25 * bound) << snr;
    EXPECT_GE(errors.found, errors.tried * 98 / 100) << snr;
  }
}

/// 0.033 wave of astigmatism in a subaperture are 2 waves over the pupil of the default bench.
TEST_P(PositionFitTest, IsNotDrawnAsideByAnAberratedSpot) {
  double worst = 0.0;
  for (const double waves : {0.033, 0.066}) {
    for (int k = 0; k < 20; ++k) {
      const double turn = 0.3 * k;
      const auto astigmatism = [&](double x, double y) {
        const double a = (x * x - y * y) * std::cos(turn) + 2.0 * x * y * std::sin(turn);
        return std::sqrt(6.0) * waves * a;
      };
      const Vec2 truth{60.3 + 0.05 * k, 60.6 + 0.083 * k};
      test::SpotImage picture;
      picture.add(GetParam(), truth, 200.0, astigmatism);
      const auto image = picture.mono16(300.0, 65535);
      const SpotFix fix = track(view_of(image, PixelFormat::mono16), truth + Vec2{1.1, -0.7});
      ASSERT_TRUE(fix.found()) << waves << ", " << k;
      worst = std::max({worst, std::abs(fix.x - truth.x), std::abs(fix.y - truth.y)});
    }
  }
  std::printf("  charge %d: worst error %.4f px\n", GetParam(), worst);
  EXPECT_LT(worst, 0.002);
}

TEST_P(PositionFitTest, IsExactWithASaturatedTop) {
  for (const double over : {1.5, 4.0, 10.0}) {
    const Vec2 truth{62.37, 60.81};
    test::SpotImage drawn;
    drawn.add(GetParam(), truth, 200.0);
    const auto image = drawn.mono16(over * 4095.0 / 200.0, 4095);
    const SpotFix fix = track(view_of(image, PixelFormat::mono12), truth + Vec2{1.1, -0.7});
    ASSERT_TRUE(fix.found()) << over;
    EXPECT_NEAR(fix.x, truth.x, 0.01) << over;
    EXPECT_NEAR(fix.y, truth.y, 0.01) << over;
  }
}

TEST_P(PositionFitTest, FindsNothingInNoiseAndFlatImages) {
  for (unsigned k = 0; k < 20; ++k) {
    test::SpotImage dark;
    dark.pedestal_dn = 20.0;
    const auto image = dark.noisy8(0.5 + k % 9, k);
    for (int i = 0; i < 6; ++i) {
      EXPECT_FALSE(track(view_of(image), {40.0 + 9 * i, 45.0 + 7 * i}).found()) << k << " " << i;
    }
  }
  for (const int level : {0, 1, 255}) {
    const Image<std::uint8_t> flat(128, 120, std::uint8_t(level));
    EXPECT_FALSE(track(view_of(flat), {64, 60}).found()) << level;
  }
}

TEST_P(PositionFitTest, LosesWhatIsNotInTheImage) {
  test::SpotImage picture;
  picture.add(GetParam(), {64, 60}, 200.0);
  const auto image = picture.mono8();
  for (const Vec2 start : {Vec2{-1, 60}, Vec2{std::nan(""), 60}, Vec2{64, 1e9}}) {
    EXPECT_FALSE(track(view_of(image), start).found());
  }
  const Image<std::uint8_t> tiny(20, 20, 9);
  EXPECT_FALSE(track(view_of(tiny), {10, 10}).found());
}

/// A coma r^3 cos t over the aperture moves the spot by the square of the ring's radius times what
/// the tilt r cos t does.
TEST(PositionFitTilt, IsThatOfTheRingForEveryCharge) {
  constexpr double kComaWaves = 0.02, kReadNoise = 6.0;
  constexpr int kFrames = 50, kSide = 144;
  const Vec2 truth{71.3, 71.6};
  const double tilt_px = 2.0 * kComaWaves * kLambdaD;
  for (int charge = 0; charge <= 8; ++charge) {
    test::SpotImage drawn(kSide, kSide);
    drawn.add(charge, truth, test::kNoisyPeak,
              [](double x, double y) { return kComaWaves * (x * x + y * y) * x; });
    const auto fit = make_position_fit({charge, kLambdaD}).value();
    TrackScratch scratch = fit->make_scratch();
    double moved_px = 0.0;
    for (unsigned k = 0; k < kFrames; ++k) {
      const auto image = test::expose12(drawn.light, kReadNoise, k);
      const SpotFix fix = fit->track(view_of(image, PixelFormat::mono12), truth, scratch);
      ASSERT_TRUE(fix.found()) << charge;
      moved_px += (double(fix.x) - truth.x) / kFrames;
    }
    const double measured = moved_px / tilt_px;
    const double expected = std::pow(position_fit_tilt_radius(charge), 2);
    std::printf("  charge %d: radius %.4f, expected %.4f\n", charge, std::sqrt(measured),
                std::sqrt(expected));
    EXPECT_NEAR(measured, expected, 0.01 * expected) << charge;
    EXPECT_EQ(position_fit_tilt_radius(-charge), position_fit_tilt_radius(charge));
  }
}

std::string charge_name(const testing::TestParamInfo<int>& info) {
  return "charge_" + std::to_string(info.param);
}
INSTANTIATE_TEST_SUITE_P(Charge, PositionFitTest, testing::Values(0, 1, 2), charge_name);

}  // namespace
}  // namespace ovws
