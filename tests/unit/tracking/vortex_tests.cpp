/// The LG tracker on vortices: against its oracle, under aberration, and among other dark places.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "core/tracking/tracker.hpp"
#include "tests/unit/tracking/synthetic_spot.hpp"

namespace ovws {
namespace {

using test::kLambdaD;
using test::SpotImage;

struct Tracker {
  std::unique_ptr<const SpotTracker> method;
  mutable TrackScratch scratch;

  explicit Tracker(TrackerKind kind, int charge = 1, double kernel = 0.4)
      : method(make_tracker({kind, kernel}, {charge, kLambdaD}).value()),
        scratch(method->make_scratch()) {}
  SpotFix operator()(const Image<std::uint8_t>& image, Vec2 start) const {
    return method->track(view_of(image), start, scratch);
  }
};

TEST(Lg, AgreesWithItsOracleOnNoisySpots) {
  const Tracker lg(TrackerKind::lg), contour(TrackerKind::lg_contour);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> offset(-0.4 * kLambdaD, 0.4 * kLambdaD);
  int both = 0;
  for (unsigned k = 0; k < 60; ++k) {
    SpotImage picture;
    picture.pedestal_dn = 6.0;
    const double astigmatism = 0.02 * (k % 6), coma = 0.015 * (k % 5);
    picture.add(1, {62.0 + 0.037 * k, 60.0 - 0.051 * k}, 40.0 + 3.0 * k, [&](double x, double y) {
      return astigmatism * (x * x - y * y) + coma * (3 * (x * x + y * y) - 2) * y;
    });
    const auto image = picture.noisy8(1.0 + k % 4, k);
    const Vec2 start{62.0 + 0.037 * k + offset(random), 60.0 - 0.051 * k + offset(random)};
    const SpotFix a = lg(image, start), b = contour(image, start);
    if (!a.found() || !b.found()) continue;
    ++both;
    EXPECT_NEAR(a.x, b.x, 0.01) << k;
    EXPECT_NEAR(a.y, b.y, 0.01) << k;
  }
  EXPECT_GE(both, 57);
}

TEST(Lg, OfChargeZeroAgreesWithItsOracleToo) {
  const Tracker lg(TrackerKind::lg, 0), contour(TrackerKind::lg_contour, 0);
  for (unsigned k = 0; k < 15; ++k) {
    SpotImage picture;
    picture.pedestal_dn = 6.0;
    picture.add(0, {62.0 + 0.07 * k, 60.0 - 0.03 * k}, 40.0 + 10.0 * k);
    const auto image = picture.noisy8(2.0, k);
    const SpotFix a = lg(image, {64, 58}), b = contour(image, {64, 58});
    EXPECT_NEAR(a.x, b.x, 0.01);
    EXPECT_NEAR(a.y, b.y, 0.01);
  }
}

TEST(Lg, ConvergesFromHalfALambdaOverDOnEverySide) {
  const Tracker lg(TrackerKind::lg);
  SpotImage picture;
  picture.add(1, {63.4, 60.8}, 150.0, [](double x, double y) { return 0.1 * x * y; });
  const auto image = picture.noisy8(1.0, 3);
  for (int k = 0; k < 24; ++k) {
    const double t = 2.0 * M_PI * k / 24;
    const Vec2 from{0.5 * kLambdaD * std::cos(t), 0.5 * kLambdaD * std::sin(t)};
    const SpotFix fix = lg(image, Vec2{63.4, 60.8} + from);
    EXPECT_NEAR(fix.x, 63.4, 0.1) << k;
    EXPECT_NEAR(fix.y, 60.8, 0.1) << k;
  }
}

TEST(Lg, FromAnywhereFindsTheCoreOrNothing) {
  // Dark places outside the ring, saddles on it, and its maxima are zeros of Psi too.
  for (const double kernel : {0.25, 0.4, 0.6}) {
    const Tracker lg(TrackerKind::lg, 1, kernel);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> x(20.0, 108.0), y(20.0, 100.0);
    int found = 0;
    for (unsigned k = 0; k < 12; ++k) {
      SpotImage picture;
      picture.add(1, {64.3, 59.6}, 200.0, [&](double u, double v) {
        return 0.03 * (k % 4) * (u * u - v * v) + 0.02 * (k % 3) * u * (u * u + v * v);
      });
      const auto image = picture.noisy8(0.5 * (k % 3), k);
      const SpotFix truth = lg(image, {64.3, 59.6});
      for (int i = 0; i < 150; ++i) {
        const SpotFix fix = lg(image, {x(random), y(random)});
        if (!fix.found()) continue;
        ++found;
        EXPECT_NEAR(fix.x, truth.x, 0.01);
        EXPECT_NEAR(fix.y, truth.y, 0.01);
      }
    }
    EXPECT_GT(found, 20);
  }
}

TEST(Lg, HoldsTheCoreUnderAstigmatismOrLosesIt) {
  const Tracker lg(TrackerKind::lg);
  bool lost = false;
  for (double waves = 0.0; waves <= 1.5; waves += 0.05) {  // amplitude inside the subaperture
    SpotImage picture(160, 160);
    picture.add(1, {80.2, 79.7}, 200.0,
                [&](double x, double y) { return waves * (x * x - y * y); });
    const SpotFix fix = lg(picture.mono8(), {80, 80});
    if (!fix.found()) {
      EXPECT_GT(waves, 0.16);  // over the whole pupil, 25 times that amplitude
      lost = true;
      continue;
    }
    EXPECT_NEAR(fix.x, 80.2, 0.05) << waves;
    EXPECT_NEAR(fix.y, 79.7, 0.05) << waves;
  }
  EXPECT_TRUE(lost) << "1.5 waves of astigmatism inside one subaperture leave no core";
}

TEST(Lg, DoesNotMoveWithThePedestal) {
  const Tracker lg(TrackerKind::lg);
  for (const double pedestal : {0.0, 20.0, 120.0}) {
    SpotImage picture;
    picture.add(1, {62.3, 60.6}, 100.0);
    picture.pedestal_dn = pedestal;
    const SpotFix fix = lg(picture.mono8(), {64, 59});
    EXPECT_NEAR(fix.x, 62.3, 0.01) << pedestal;
    EXPECT_NEAR(fix.y, 60.6, 0.01) << pedestal;
    EXPECT_GT(fix.quality, 0.8F) << "above the local background, whatever that is";
  }
}

TEST(Lg, LosesARingThatIsNotClosed) {
  SpotImage picture;
  picture.add(1, {64, 60}, 200.0);
  auto image = picture.mono8();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 64; x < image.width; ++x) {
      if (std::abs(y - 60) < x - 64) image.at(x, y) = 0;
    }
  }
  const Tracker lg(TrackerKind::lg);
  EXPECT_FALSE(lg(image, {64, 60}).found());
}

TEST(Lg, LosesTheDarkPlaceBetweenBrightSpots) {
  SpotImage picture(160, 160);
  for (int k = 0; k < 6; ++k) {
    const double t = M_PI / 3.0 * k;
    picture.add(0, {80 + 26 * std::cos(t), 80 + 26 * std::sin(t)}, 200.0);
  }
  const auto image = picture.noisy8(1.0, 1);
  const Tracker lg(TrackerKind::lg);
  for (int k = -6; k <= 6; ++k) EXPECT_FALSE(lg(image, {80.0 + k, 80.0 + 0.5 * k}).found()) << k;
}

TEST(Lg, NextToANeighbourKeepsItsOwn) {
  SpotImage picture(200, 120);
  picture.add(1, {64, 60}, 180.0);
  picture.add(1, {64 + 3.4 * kLambdaD, 60}, 180.0);
  const auto image = picture.noisy8(1.0, 2);
  const Tracker lg(TrackerKind::lg);
  EXPECT_NEAR(lg(image, {67, 58}).x, 64.0, 0.1);
  EXPECT_NEAR(lg(image, {103, 62}).x, 64.0 + 3.4 * kLambdaD, 0.1);
}

TEST(Lg, OfChargeTwoTracksTheMeanOfTheSplitCores) {
  // Astigmatism inside the subaperture splits a double core symmetrically about the truth.
  for (const int charge : {2, -2}) {
    const Tracker lg(TrackerKind::lg, charge);
    for (double waves = 0.0; waves <= 0.101; waves += 0.02) {
      SpotImage picture(160, 160);
      picture.add(charge, {80.3, 79.4}, 200.0,
                  [&](double x, double y) { return waves * (x * x - y * y + x * y); });
      const SpotFix fix = lg(picture.noisy8(1.0, 4), {79, 80});
      EXPECT_NEAR(fix.x, 80.3, 0.1) << charge << ", " << waves;
      EXPECT_NEAR(fix.y, 79.4, 0.1) << charge << ", " << waves;
    }
  }
}

}  // namespace
}  // namespace ovws
