/// The matched filter: accuracy, capture range, and rejection of everything that is no spot.
#include "core/tracking/matched.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/tracking/acquisition.hpp"
#include "core/tracking/reference_shape.hpp"
#include "tests/support/alloc_guard.hpp"
#include "tests/unit/tracking/sensor_image.hpp"
#include "tests/unit/tracking/synthetic_spot.hpp"

namespace ovws {
namespace {

using test::SpotPicture;
constexpr double kLambdaD = 12.55;

Image<std::uint8_t> painted(const std::function<int(int, int)>& value) {
  Image<std::uint8_t> image(128, 120);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) image.at(x, y) = std::uint8_t(value(x, y));
  }
  return image;
}

class Matched : public testing::TestWithParam<int> {
 protected:
  Matched() : tracker_({GetParam(), kLambdaD}), scratch_(tracker_.make_scratch()) {}

  SpotPicture spot_at(Vec2 at, double peak_dn = 200.0) const {
    SpotPicture picture;
    picture.add(GetParam(), at, peak_dn);
    return picture;
  }
  SpotFix track(const Image<std::uint8_t>& image, Vec2 start) {
    return tracker_.track(view_of(image), start, scratch_);
  }
  /// Tracks from every start of a grid around the middle.
  void expect_lost(const Image<std::uint8_t>& image, const std::string& what) {
    for (int k = 0; k < 9; ++k) {
      const SpotFix fix = track(image, {60.0 + 4.0 * (k % 3), 56.0 + 4.0 * (k / 3)});
      EXPECT_FALSE(fix.found()) << what << ": " << fix.x << ", " << fix.y << " quality "
                                << fix.quality;
    }
  }

  MatchedTracker tracker_;
  TrackScratch scratch_;
};

TEST_P(Matched, RecoversAnySubPixelPositionIn8And16Bits) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(57.0, 65.0), off(-2.0, 2.0);
  double worst8 = 0.0, worst16 = 0.0;
  for (int k = 0; k < 12; ++k) {
    const Vec2 truth{place(random), place(random)};
    const Vec2 start = truth + Vec2{off(random), off(random)};
    const SpotPicture picture = spot_at(truth);
    const auto wide = picture.mono16(200.0, 65535);
    const SpotFix a = track(picture.mono8(), start);
    const SpotFix b = tracker_.track(view_of(wide, PixelFormat::mono16), start, scratch_);
    worst8 = std::max(worst8, norm(Vec2{double(a.x), double(a.y)} - truth));
    worst16 = std::max(worst16, norm(Vec2{double(b.x), double(b.y)} - truth));
    EXPECT_GT(a.quality, 0.95F);
    EXPECT_NEAR(a.level, 150.0F, 20.0F);
  }
  std::printf("  charge %d: worst error %.5f px of 8 bits, %.5f px of 16\n", GetParam(), worst8,
              worst16);
  EXPECT_LT(worst8, 0.003);
  EXPECT_LT(worst16, 0.003);
}

TEST_P(Matched, IsFoundFromHalfALambdaOverDOnEverySide) {
  const Vec2 truth{63.4, 60.8};
  SpotPicture picture = spot_at(truth, 150.0);
  picture.pedestal_dn = 12.0;
  const auto image = picture.noisy8(1.0, 3);
  for (const double radius : {0.25, 0.5, 0.7}) {
    for (int k = 0; k < 24; ++k) {
      const double t = 2.0 * M_PI * k / 24;
      const SpotFix fix = track(image, truth + radius * kLambdaD * Vec2{std::cos(t), std::sin(t)});
      EXPECT_NEAR(fix.x, truth.x, 0.03) << radius << ", " << k;
      EXPECT_NEAR(fix.y, truth.y, 0.03) << radius << ", " << k;
    }
  }
}

/// 0.033 wave of astigmatism in a subaperture are 2 waves over the pupil of the default bench.
TEST_P(Matched, IsNotDrawnToItsTemplatesShiftsByAnAberratedSpot) {
  double worst = 0.0;
  for (const double waves : {0.033, 0.066}) {
    for (int k = 0; k < 20; ++k) {
      const double turn = 0.3 * k;
      const auto astigmatism = [&](double x, double y) {
        const double a = (x * x - y * y) * std::cos(turn) + 2.0 * x * y * std::sin(turn);
        return std::sqrt(6.0) * waves * a;
      };
      const Vec2 truth{60.3 + 0.05 * k, 60.6 + 0.083 * k};
      SpotPicture picture;
      picture.add(GetParam(), truth, 200.0, astigmatism);
      const auto image = picture.mono16(300.0, 65535);
      const SpotFix fix =
          tracker_.track(view_of(image, PixelFormat::mono16), truth + Vec2{1.1, -0.7}, scratch_);
      ASSERT_TRUE(fix.found()) << waves << ", " << k;
      worst = std::max({worst, std::abs(fix.x - truth.x), std::abs(fix.y - truth.y)});
    }
  }
  std::printf("  charge %d: worst error %.4f px\n", GetParam(), worst);
  EXPECT_LT(worst, 0.002);
}

TEST_P(Matched, HardlyDependsOnTheStart) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto image = spot_at({61.1, 59.37}, 60.0).noisy8(6.0, seed);
    const SpotFix first = track(image, {61, 59});
    for (int k = 0; k < 8; ++k) {
      const SpotFix fix = track(image, {59.0 + 0.5 * k, 61.0 - 0.6 * k});
      EXPECT_NEAR(fix.x, first.x, 0.02) << seed;
      EXPECT_NEAR(fix.y, first.y, 0.02) << seed;
    }
  }
}

TEST_P(Matched, LosesStripesOfEveryWidth) {
  for (const int half : {0, 1, 2, 3, 4, 6, 8, 10, 14, 20}) {
    const std::string width = std::to_string(2 * half + 1);
    const auto level = [&](int distance) { return std::abs(distance) <= half ? 180 : 10; };
    expect_lost(painted([&](int, int y) { return level(y - 60); }), "row " + width);
    expect_lost(painted([&](int x, int) { return level(x - 63); }), "column " + width);
    expect_lost(painted([&](int x, int y) { return level((x - y - 3) * 7 / 10); }), "oblique");
    expect_lost(painted([&](int, int y) { return 190 - level(y - 60); }), "dark row " + width);
  }
}

TEST_P(Matched, LosesHotPixelsAndSharpCorners) {
  for (const int side : {1, 2, 3, 4}) {
    expect_lost(painted([&](int x, int y) {
                  const bool hot = x >= 62 && x < 62 + side && y >= 58 && y < 58 + side;
                  return hot ? 255 : 9 + (x * 7 + y * 13) % 3;
                }),
                "hot " + std::to_string(side));
  }
  expect_lost(painted([](int x, int y) { return x > 62 && y > 58 ? 200 : 10; }), "corner");
  expect_lost(painted([](int x, int y) { return (x / 6 + y / 6) % 2 == 0 ? 200 : 10; }), "chess");
  const auto ring = [](int x, int y) { return std::hypot(x - 62, y - 60); };
  expect_lost(painted([&](int x, int y) { return ring(x, y) < 45 ? 200 : 10; }), "disc");
  expect_lost(painted([&](int x, int y) { return std::abs(ring(x, y) - 40) < 6 ? 200 : 10; }),
              "far ring");
}

TEST_P(Matched, LosesHalfASpot) {
  auto image = spot_at({64, 60}).mono8();
  for (int y = 0; y < image.height; ++y) std::fill(image.row(y) + 64, image.row(y) + 128, 0);
  EXPECT_FALSE(track(image, {64, 60}).found());
}

TEST_P(Matched, ToleratesAHotPixelOrLosesTheSpot) {
  for (const Vec2 hot : {Vec2{62, 60}, Vec2{63, 61}, Vec2{66, 60}, Vec2{62, 71}, Vec2{50, 52}}) {
    auto image = spot_at({62.3, 60.2}, 120.0).noisy8(2.0, 7);
    image.at(int(hot.x), int(hot.y)) = 255;
    const SpotFix fix = track(image, {62, 60});
    if (!fix.found()) continue;
    EXPECT_NEAR(fix.x, 62.3, 0.1 * kLambdaD) << hot.x;
    EXPECT_NEAR(fix.y, 60.2, 0.1 * kLambdaD) << hot.x;
  }
}

TEST_P(Matched, KeepsItsOwnBesideANeighbourAndFindsNoneBetween) {
  SpotPicture picture(220, 120);
  picture.add(GetParam(), {70, 60}, 180.0);
  picture.add(GetParam(), {70 + 4.6 * kLambdaD, 60}, 180.0);
  const auto image = picture.noisy8(1.0, 2);
  EXPECT_NEAR(track(image, {73, 58}).x, 70.0, 0.05);
  EXPECT_NEAR(track(image, {125, 62}).x, 70.0 + 4.6 * kLambdaD, 0.05);
  for (double x = 70 + 1.3 * kLambdaD; x < 70 + 3.3 * kLambdaD; x += 3.1) {
    EXPECT_FALSE(track(image, {x, 61}).found()) << x;
  }
}

TEST_P(Matched, LosesASpotOfAnotherKind) {
  for (const int other : {0, 1, 2}) {
    if (other == std::abs(GetParam())) continue;
    SpotPicture picture;
    picture.add(other, {64, 60}, 200.0);
    expect_lost(picture.mono8(), "charge " + std::to_string(other));
  }
}

TEST_P(Matched, LosesAnythingInTinyImages) {
  for (const int side : {1, 2, 9}) {
    const Image<std::uint8_t> image(side, side, 200);
    const SpotFix fix = track(image, {0, 0});
    EXPECT_FALSE(fix.found());
    EXPECT_EQ(fix.peak, 200.0F);
  }
}

TEST_P(Matched, FollowsAReferenceSpotThatIsNotTheModels) {
  const auto waves = [](double x, double y) {
    return 0.06 * (x * x - y * y) + 0.05 * (3 * (x * x + y * y) - 2) * y;
  };
  const Vec2 reference{60.35, 59.8};
  SpotPicture at_reference;
  at_reference.add(GetParam(), reference, 200.0, waves);
  at_reference.pedestal_dn = 15.0;
  Image<float> average = at_reference.light;
  for (float& pixel : average.pixels) pixel += 15.0F;
  const std::vector<Vec2> positions{{NAN, 3.0}, reference, {1e9, 0.0}};
  const auto banks = reference_templates({GetParam(), kLambdaD}, average, positions);
  ASSERT_EQ(banks.size(), 3U);
  EXPECT_EQ(banks[0], nullptr);
  EXPECT_EQ(banks[2], nullptr);
  ASSERT_NE(banks[1], nullptr);
  const MatchedTracker own({GetParam(), kLambdaD}, banks);
  auto scratch = own.make_scratch();
  for (const Vec2 move : {Vec2{0, 0}, Vec2{1.37, -2.21}, Vec2{-0.61, 0.13}}) {
    SpotPicture moved;
    moved.add(GetParam(), reference + move, 170.0, waves);
    const auto image = moved.mono16(200.0, 65535);
    const ImageView view = view_of(image, PixelFormat::mono16);
    const SpotFix fix = own.track(view, reference, scratch, 1);
    EXPECT_NEAR(fix.x, reference.x + move.x, 0.004);
    EXPECT_NEAR(fix.y, reference.y + move.y, 0.004);
    EXPECT_GT(fix.quality, 0.99F);
    const SpotFix others = own.track(view, reference, scratch, 0);
    EXPECT_EQ(others.x, tracker_.track(view, reference, scratch_).x) << "no template: the model's";
    EXPECT_EQ(others.x, own.track(view, reference, scratch, 17).x);
  }
  const auto image = at_reference.mono8();
  const test::AllocGuard guard;
  const SpotFix fix = own.track(view_of(image), reference, scratch, 1);
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_TRUE(fix.found());
}

TEST_P(Matched, TracksSpotsOfEverySize) {
  for (const double lambda_d : {4.0, 5.5, 8.0, 25.0}) {
    const MatchedTracker tracker({GetParam(), lambda_d});
    auto scratch = tracker.make_scratch();
    SpotPicture picture(180, 180);
    picture.lambda_d_px = lambda_d;
    picture.add(GetParam(), {90.3, 89.6}, 200.0);
    const auto image = picture.mono8();
    const SpotFix fix = tracker.track(view_of(image), {90, 90}, scratch);
    EXPECT_NEAR(fix.x, 90.3, 0.005) << lambda_d;
    EXPECT_NEAR(fix.y, 89.6, 0.005) << lambda_d;
  }
}

std::string charge_name(const testing::TestParamInfo<int>& info) {
  return info.param < 0 ? "minus_" + std::to_string(-info.param) : std::to_string(info.param);
}
INSTANTIATE_TEST_SUITE_P(Charge, Matched, testing::Values(0, 1, -1, 2), charge_name);

TEST(MatchedAcquisition, TracksEachSpotByItsOwnTemplateOnceItIsKnown) {
  auto& bench = test::sensor_bench(1);
  const Image<float> light = bench.light({});
  Image<float> average = light;
  for (float& pixel : average.pixels) pixel = 200.0F * pixel + 2.0F;
  const SpotModel spots{1, bench.lambda_d};
  const MatchedTracker own(spots, reference_templates(spots, average, bench.model_px));
  auto scratch = own.make_scratch();
  Acquisition acquisition(spots, bench.model_px, 512, 512);
  std::vector<SpotFix> fixes(19);
  const auto image = test::expose8(light, 200.0, 1.0, 2.0);
  ASSERT_EQ(acquisition.acquire(view_of(image), own, scratch, fixes), 19);
  for (int i = 0; i < 19; ++i) {
    // A template of the spot at its reference position finds it there; the model's need not.
    EXPECT_NEAR(fixes[i].x, bench.model_px[i].x, 0.03) << i;
    EXPECT_NEAR(fixes[i].y, bench.model_px[i].y, 0.03) << i;
  }
}

/// Sum I x / sum I above a threshold over 64 x 64 pixels in one pass, to compare the speed with.
double plain_centroid(const ImageView& image, int left, int top) {
  constexpr int kSide = 64;
  double light = 0.0, x_sum = 0.0, y_sum = 0.0;
  for (int y = 0; y < kSide; ++y) {
    const std::uint16_t* row = image.row<std::uint16_t>(top + y) + left;
    unsigned sum = 0, moment = 0;
    for (int x = 0; x < kSide; ++x) {
      const unsigned above = row[x] > 30 ? row[x] - 30U : 0U;
      sum += above;
      moment += above * unsigned(x);
    }
    light += sum;
    x_sum += moment;
    y_sum += double(sum) * y;
  }
  return (x_sum + y_sum) / light;
}

/// Microseconds of one call: the minimum of several runs, which other load disturbs least.
template <class Call>
double microseconds(Call call) {
  constexpr int kCalls = 400;
  double best = 1e9;
  for (int turn = 0; turn < 7; ++turn) {
    const auto begin = std::chrono::steady_clock::now();
    for (int k = 0; k < kCalls; ++k) call(k);
    const std::chrono::duration<double, std::micro> taken =
        std::chrono::steady_clock::now() - begin;
    best = std::min(best, taken.count() / kCalls);
  }
  return best;
}

TEST(MatchedPrinted, SpeedIsShownNotJudged) {
  for (const int charge : {0, 1}) {
    SpotPicture picture;
    picture.pedestal_dn = 20.0;
    picture.add(charge, {63.3, 60.1}, 200.0);
    const auto image = picture.mono16(4.0, 4095);
    const ImageView view = view_of(image, PixelFormat::mono12);
    const auto time = [&](const SpotTracker& tracker) {
      auto scratch = tracker.make_scratch();
      return microseconds([&](int k) {
        tracker.track(view, {63.3 + 0.1 * (k % 16), 60.1 + 0.1 * (k / 16 % 16)}, scratch);
      });
    };
    volatile double sink = 0.0;
    const double centroid =
        microseconds([&](int k) { sink = sink + plain_centroid(view, 31 + k % 2, 28); });
    const double matched = time(MatchedTracker({charge, kLambdaD}));
    const double lg = time(*make_tracker({TrackerKind::lg, 0.3}, {charge, kLambdaD}).value());
    std::printf("  charge %d: matched %.2f us a spot, lg %.2f us, centroid of 64 x 64 %.2f us\n",
                charge, matched, lg, centroid);
  }
}

}  // namespace
}  // namespace ovws
