/// Spots lost in push-pull pokes are filled in from the other image, or from the model.
#include "core/wavefront/interaction_matrix.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/wavefront/push_pull_bench.hpp"

namespace ovws {
namespace {

constexpr Vec2 kLost{NAN, NAN};
constexpr std::size_t kMode = 6;

class LostPushes : public testing::Test {
 protected:
  LostPushes() {
    bench_.truth = 1.3 * bench_.model;  // the bench moves spots farther than the model says
    const PushPullRun run = bench_.run();
    resting_ = run.before;
    whole_ = push_ = run.modes[kMode];
  }

  void fill() { fill_lost(resting_, bench_.model.col(kMode), push_); }
  void expect_whole(std::size_t i) const {
    EXPECT_LT(norm(push_.plus.at_px[i] - whole_.plus.at_px[i]), 1e-6) << i;
    EXPECT_LT(norm(push_.minus.at_px[i] - whole_.minus.at_px[i]), 1e-6) << i;
  }

  PushPullBench bench_;
  SpotMeans resting_;
  PushPull whole_, push_;
};

TEST_F(LostPushes, AreMirroredAtWhereTheSpotRests) {
  push_.plus.at_px[2] = kLost;
  push_.minus.at_px[17] = kLost;
  fill();
  expect_whole(2);
  expect_whole(17);
}

TEST_F(LostPushes, OfBothImagesFollowTheModelTimesWhatTheOthersMoved) {
  push_.plus.at_px[0] = push_.minus.at_px[0] = kLost;
  push_.plus.at_px[5] = kLost;
  fill();
  expect_whole(0);
  expect_whole(5);
  const double moved_px = norm(whole_.plus.at_px[0] - resting_.at_px[0]);
  EXPECT_NEAR(push_.plus.standard_error_px[0].x, 0.2 * moved_px, 1e-6);
}

TEST_F(LostPushes, AreLeftAloneIfThereAreTooMany) {
  for (std::size_t i = 0; i < 5; ++i) push_.plus.at_px[i] = kLost;  // of 19
  fill();
  EXPECT_EQ(lost_by(push_, resting_).size(), 5U);
  push_.plus.at_px[4] = whole_.plus.at_px[4];
  fill();
  EXPECT_TRUE(lost_by(push_, resting_).empty());
}

/// The limit counts the spots that were found at rest.
TEST_F(LostPushes, AreTooManyOfThoseThatAreFoundAtRest) {
  for (std::size_t i = 10; i < 15; ++i) resting_.at_px[i] = kLost;  // 14 of 19 are left
  for (std::size_t i = 0; i < 4; ++i) push_.plus.at_px[i] = kLost;
  fill();
  EXPECT_EQ(lost_by(push_, resting_).size(), 4U);
}

TEST_F(LostPushes, OfASpotThatDoesNotRestAnywhereStayLost) {
  resting_.at_px[3] = kLost;
  push_.plus.at_px[3] = kLost;
  fill();
  EXPECT_TRUE(std::isnan(push_.plus.at_px[3].x));
}

}  // namespace
}  // namespace ovws
