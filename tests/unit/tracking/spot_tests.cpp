/// Tracker names, the geometry of a spot, and the rejection of faint spots.
#include <gtest/gtest.h>

#include <vector>

#include "core/tracking/spot.hpp"
#include "core/tracking/spot_geometry.hpp"
#include "core/tracking/spot_shape.hpp"
#include "tests/support/alloc_guard.hpp"
#include "tests/unit/tracking/synthetic_spot.hpp"

namespace ovws {
namespace {

TEST(TrackerNames, GoThereAndBack) {
  for (const TrackerKind kind :
       {TrackerKind::centroid, TrackerKind::thresholded, TrackerKind::weighted,
        TrackerKind::lg_contour, TrackerKind::lg, TrackerKind::fit}) {
    EXPECT_EQ(tracker_from_name(tracker_name(kind)), kind);
  }
  EXPECT_EQ(tracker_name(TrackerKind::lg_contour), "lg_contour");
  EXPECT_FALSE(tracker_from_name("LG").has_value());
  EXPECT_FALSE(tracker_from_name("").has_value());
}

TEST(SpotGeometry, OfABrightSpotIsTheAiryPattern) {
  const SpotGeometry g = spot_geometry(0);
  EXPECT_NEAR(g.ring_outer, 0.514, 0.03);  // half width of (2 J1(pi r) / (pi r))^2
  EXPECT_NEAR(g.dark, 1.220, 0.03);
  EXPECT_NEAR(spot_intensity(0, 1.2197) / spot_intensity(0, 0.0), 0.0, 1e-6);
}

TEST(SpotGeometry, OfAVortexIsWhatAFourierSumShows) {
  for (const int charge : {1, -1, 2, 3}) {
    test::SpotImage picture(161, 161);
    picture.add(charge, {80, 80}, 100.0);
    const double ring = spot_geometry(charge).ring;
    const double scale = 100.0 / spot_intensity(charge, ring);
    for (int x = 80; x < 110; x += 3) {
      const double r = (x - 80) / picture.lambda_d_px;
      EXPECT_NEAR(picture.light.at(x, 80), scale * spot_intensity(charge, r), 1.5)
          << "charge " << charge << " at " << r;
    }
  }
}

TEST(SpotGeometry, RadiiAreInOrderAndGrowWithTheCharge) {
  double before = 0.0;
  for (int charge = 1; charge <= 8; ++charge) {
    const SpotGeometry g = spot_geometry(charge);
    EXPECT_LT(g.ring_inner, g.ring);
    EXPECT_LT(g.ring, g.ring_outer);
    EXPECT_LT(g.ring_outer, g.dark);
    EXPECT_GT(g.ring, before);
    before = g.ring;
  }
}

SpotFix fix_of_level(float level) {
  return {.x = 1.0F, .y = 2.0F, .peak = 3.0F, .quality = 1.0F, .level = level};
}

TEST(DropFaint, LosesWhatIsBelowATenthOfTheMedian) {
  std::vector<SpotFix> spots{fix_of_level(100), fix_of_level(7), fix_of_level(120), SpotFix{},
                             fix_of_level(80)};
  EXPECT_EQ(drop_faint(spots, 5), 3);
  EXPECT_FALSE(spots[1].found());
  EXPECT_EQ(spots[1].quality, 0.0F);
  EXPECT_EQ(spots[1].peak, 3.0F);
  EXPECT_TRUE(spots[4].found());
}

TEST(DropFaint, MeasuresAgainstTheExpectedNumberOfBrightest) {
  std::vector<SpotFix> spots(20, fix_of_level(2));
  spots[3] = spots[7] = spots[11] = fix_of_level(100);
  EXPECT_EQ(drop_faint(spots, 4), 3);
}

TEST(DropFaint, KeepsAllOfAnEvenFrameAndCopesWithNone) {
  std::vector<SpotFix> spots(19, fix_of_level(5));
  EXPECT_EQ(drop_faint(spots, 19), 19);
  std::vector<SpotFix> lost(19);
  EXPECT_EQ(drop_faint(lost, 19), 0);
  EXPECT_EQ(drop_faint({}, 0), 0);
}

TEST(AllocGuard, SeesEveryKindOfAllocation) {
  // A guard that misses allocations would make every test that uses it worthless.
  const test::AllocGuard guard;
  EXPECT_EQ(guard.allocations(), 0U);
  auto* one = new double(1.0);
  EXPECT_EQ(guard.allocations(), 1U);
  std::vector<float> grown;
  grown.push_back(1.0F);
  EXPECT_EQ(guard.allocations(), 2U);
  void* raw = std::malloc(16);
  EXPECT_EQ(guard.allocations(), 3U);
  EXPECT_NE(raw, nullptr);
  std::free(raw);
  delete one;
  EXPECT_EQ(guard.allocations(), 3U);
}

TEST(ModelShape, IsTheSpotsProfileWithItsGradient) {
  for (const int charge : {0, 1, -2}) {
    const ModelShape shape({charge, 12.55}, 4.0);
    const double peak = spot_intensity(charge, spot_geometry(charge).ring);
    for (double r = 0.0; r < 4.0; r += 0.0713) {
      const Vec2 at = r * 12.55 * Vec2{0.6, -0.8};
      const ShapeSample s = shape.at(at);
      EXPECT_NEAR(s.value, spot_intensity(charge, r) / peak, 2e-5) << r;
      constexpr double kStep = 1e-4;
      EXPECT_NEAR(s.dx, (shape.at(at + Vec2{kStep, 0}).value - s.value) / kStep, 1e-5) << r;
      EXPECT_NEAR(s.dy, (shape.at(at + Vec2{0, kStep}).value - s.value) / kStep, 1e-5) << r;
    }
  }
}

}  // namespace
}  // namespace ovws
