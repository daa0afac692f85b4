/// The trackers of the conventional sensor, charge 0.
#include <gtest/gtest.h>

#include <memory>

#include "core/tracking/tracker.hpp"
#include "tests/unit/tracking/synthetic_spot.hpp"

namespace ovws {
namespace {

using test::kLambdaD;
using test::SpotImage;

SpotFix track(TrackerKind kind, const Image<std::uint8_t>& image, Vec2 start) {
  const auto tracker = make_tracker({kind, 0.5}, {0, kLambdaD}).value();
  auto scratch = tracker->make_scratch();
  return tracker->track(view_of(image), start, scratch);
}

SpotImage spot(Vec2 at, double pedestal_dn) {
  SpotImage picture;
  picture.add(0, at, 180.0);
  picture.pedestal_dn = pedestal_dn;
  return picture;
}

TEST(BrightSpot, OfThresholdedAndWeightedAndLgDoesNotMoveWithThePedestal) {
  for (const auto kind : {TrackerKind::thresholded, TrackerKind::weighted, TrackerKind::lg}) {
    const SpotFix fix = track(kind, spot({66.0, 61.5}, 40.0).mono8(), {62, 58});
    EXPECT_NEAR(fix.x, 66.0, 0.01) << tracker_name(kind);
    EXPECT_NEAR(fix.y, 61.5, 0.01) << tracker_name(kind);
  }
}

TEST(BrightSpot, OfThePlainCentroidIsDrawnToItsStartByAPedestal) {
  // The bias belongs to the paper's baseline; this test documents it.
  const SpotFix without = track(TrackerKind::centroid, spot({66, 60}, 0.0).mono8(), {62, 60});
  const SpotFix with = track(TrackerKind::centroid, spot({66, 60}, 10.0).mono8(), {62, 60});
  EXPECT_GT(without.x, 65.7F);
  EXPECT_LT(with.x, 65.0F);
  EXPECT_GT(with.x, 62.5F);
}

TEST(BrightSpot, OfWeightedIsThatOfLgWithTheSameWindow) {
  SpotImage picture;
  picture.add(0, {61.3, 59.2}, 200.0, [](double x, double y) { return 0.1 * x * (x * x + y * y); });
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto image = picture.noisy8(2.0, seed);
    const SpotFix weighted = track(TrackerKind::weighted, image, {61, 60});
    const SpotFix lg = track(TrackerKind::lg, image, {61, 60});
    EXPECT_NEAR(weighted.x, lg.x, 0.003);
    EXPECT_NEAR(weighted.y, lg.y, 0.003);
  }
}

TEST(BrightSpot, IsFoundFromANearbyStartOnEverySide) {
  for (const auto kind : {TrackerKind::thresholded, TrackerKind::weighted, TrackerKind::lg}) {
    const auto image = spot({64, 60}, 5.0).mono8();
    for (const Vec2 from : {Vec2{9, 0}, Vec2{-9, 0}, Vec2{0, 9}, Vec2{0, -9}, Vec2{7, 7}}) {
      const SpotFix fix = track(kind, image, Vec2{64, 60} + from);
      EXPECT_NEAR(fix.x, 64.0, 0.02) << tracker_name(kind);
      EXPECT_NEAR(fix.y, 60.0, 0.02) << tracker_name(kind);
    }
  }
}

TEST(BrightSpot, IsNotAVortexAndTheOtherWayRound) {
  SpotImage vortex;
  vortex.add(1, {64, 60}, 200.0);
  const auto ring = vortex.mono8();
  for (const auto kind :
       {TrackerKind::thresholded, TrackerKind::weighted, TrackerKind::centroid, TrackerKind::lg}) {
    EXPECT_FALSE(track(kind, ring, {64, 60}).found()) << tracker_name(kind);
  }
  const auto lg = make_tracker({TrackerKind::lg, 0.4}, {1, kLambdaD}).value();
  auto scratch = lg->make_scratch();
  const auto image = spot({64, 60}, 0.0).mono8();
  for (int k = 0; k < 12; ++k) {
    EXPECT_FALSE(lg->track(view_of(image), {58.0 + k, 60}, scratch).found());
  }
}

}  // namespace
}  // namespace ovws
