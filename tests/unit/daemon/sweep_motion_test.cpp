#include "daemon/ovwsd/procedures/sweep_frames.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/daemon/sweep_frame.hpp"

namespace ovws {
namespace {

/// Frames of spots at `places`, displaced alternately by +-`scatter_px` along both axes.
std::vector<SeriesFrame> scattered(std::vector<Vec2> places, int frames, double scatter_px) {
  std::vector<SeriesFrame> series;
  for (int k = 0; k < frames; ++k) {
    const double off_px = k % 2 == 0 ? scatter_px : -scatter_px;
    std::vector<Vec2> now = places;
    for (Vec2& place : now) place = place + Vec2{off_px, off_px};
    series.push_back(test::frame_at(now));
  }
  return series;
}

TEST(SweepMotion, CountsWhatAllSpotsShareAndNamesTheFarthest) {
  const std::vector<Vec2> before{{10, 10}, {50, 10}, {30, 40}};
  const SpotMotion motion = spot_motion(before, 100, scattered({{12, 9}, {52, 9}, {33, 40}}, 4, 0));
  EXPECT_EQ(motion.lost, 0);
  EXPECT_NEAR(motion.mean_px.x, 7.0 / 3.0, 1e-6);
  EXPECT_NEAR(motion.mean_px.y, -2.0 / 3.0, 1e-6);
  EXPECT_NEAR(motion.largest_px, 3.0, 1e-6);
  EXPECT_EQ(motion.largest_at, 2);
  EXPECT_EQ(motion.standard_error_px, 0.0);
  const auto refused = check_unmoved(motion, 0.6, "charge 1, lg");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::refused);
  EXPECT_EQ(refused.error().field, "anew");
  for (const char* part : {"charge 1, lg", "subaperture 2 by 3.00 px", "(+2.33, -0.67) px",
                           "0.60 px", "\"anew\": true"}) {
    EXPECT_NE(refused.error().reason.find(part), std::string::npos) << part;
  }
  EXPECT_TRUE(check_unmoved(motion, 3.01, "charge 1, lg"));
}

/// Standard error for 16 frames with 0.2 px of scatter before and after: sqrt(16/15) * 0.2 *
/// sqrt(2/16) px.
TEST(SweepMotion, IsNotDistinguishedFromNoiseThatIsAsLarge) {
  const std::vector<Vec2> before{{10, 10}, {50, 10}};
  const SpotMotion still = spot_motion(before, 16, scattered(before, 16, 0.2));
  const double error_px = std::sqrt(16.0 / 15.0) * 0.2 * std::sqrt(2.0 / 16.0);
  EXPECT_NEAR(still.standard_error_px, error_px, 1e-5);
  EXPECT_NEAR(still.largest_px, 0.0, 1e-5);
  EXPECT_TRUE(check_unmoved(still, 4.1 * error_px, "arm"));
  const auto unknown = check_unmoved(still, 3.9 * error_px, "arm");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().field, "reference_frames");
  // A displacement larger than the noise is still reported as motion.
  const SpotMotion moved = spot_motion(before, 16, scattered({{11, 10}, {50, 10}}, 16, 0.2));
  EXPECT_EQ(check_unmoved(moved, 3.9 * error_px, "arm").error().field, "anew");
}

TEST(SweepMotion, MissesSpotsThatTheReferenceHad) {
  auto frames = scattered({{10, 10}, {50, 10}, {90, 10}}, 4, 0.0);
  for (SeriesFrame& frame : frames) frame.spots[0] = frame.spots[1] = SpotFix{};
  const SpotMotion motion = spot_motion({{10, 10}, {NAN, NAN}, {90, 10}}, 4, frames);
  EXPECT_EQ(motion.lost, 1);
  EXPECT_EQ(motion.largest_px, 0.0);
  const auto refused = check_unmoved(motion, 1.0, "arm");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "anew");
  EXPECT_EQ(spot_motion({{10, 10}}, 4, {}).lost, 1);
}

}  // namespace
}  // namespace ovws
