/// SpotHistory: which frames follow from one that templates described.
#include <gtest/gtest.h>

#include "core/pipeline/spot_history.hpp"
#include "tests/unit/pipeline/spot_bench.hpp"

namespace ovws::test {
namespace {

constexpr int kSpots = 19;

struct Follows : testing::Test {
  SpotBench bench;
  std::unique_ptr<MeasurementPlan> plan = bench.plan(1);
  SpotHistory history;
  FrameRecord record;
  std::vector<Vec2> at_px = bench.model_px;

  Follows() {
    record.plan = plan.get();
    record.hologram_id = 1;
    record.spot_count = kSpots;
    record.spots.resize(kSpots);
    record.starts.resize(kSpots);
  }

  /// Measures a frame with the spots at `at_px`; NaN: lost.
  bool next(bool described) {
    history.fit_to(*plan);
    history.starts(record, record.starts);
    for (std::size_t i = 0; i < kSpots; ++i) {
      record.spots[i] = {float(at_px[i].x), float(at_px[i].y), 100.0F, 1.0F, 100.0F};
    }
    record.templates.credible = described;
    record.follows = history.is_followed_by(record);
    history.learn(record);
    return record.follows;
  }
  double lambda_d_px() const { return plan->spots.lambda_d_px; }
};

TEST_F(Follows, SmallStepsFromAFrameThatTemplatesDescribe) {
  EXPECT_FALSE(next(false));
  EXPECT_TRUE(next(true));
  for (int k = 0; k < 20; ++k) {
    at_px[7].x += 0.2 * lambda_d_px();
    EXPECT_TRUE(next(false)) << k;
  }
}

TEST_F(Follows, NoLongerAfterALargeStepUntilTemplatesDescribeAFrame) {
  EXPECT_TRUE(next(true));
  at_px[7].x += 0.3 * lambda_d_px();
  EXPECT_FALSE(next(false));
  EXPECT_FALSE(next(false));
  EXPECT_TRUE(next(true));
  EXPECT_TRUE(next(false));
}

TEST_F(Follows, NotAfterALostSpotUnlessTheReferenceLacksIt) {
  const Vec2 place = at_px[7], nowhere{NAN, NAN};
  EXPECT_TRUE(next(true));
  at_px[7] = nowhere;
  EXPECT_FALSE(next(false));
  at_px[7] = place;
  EXPECT_FALSE(next(false));
  plan->reference_px[7] = nowhere;
  EXPECT_TRUE(next(true));
  at_px[7] = nowhere;
  EXPECT_TRUE(next(false));
}

/// Templates may describe a frame without one of its spots.
TEST_F(Follows, SpotsThatTheTemplatesLeftOutIfTheyAreNearTheirLastPlace) {
  const Vec2 place = at_px[7];
  EXPECT_TRUE(next(true));
  at_px[7] = {NAN, NAN};
  EXPECT_TRUE(next(true));
  at_px[7] = {place.x + 0.2 * lambda_d_px(), place.y};
  EXPECT_TRUE(next(false));
  at_px[7] = {NAN, NAN};
  EXPECT_TRUE(next(true));
  at_px[7] = place + Vec2{0.5 * lambda_d_px(), 0.0};
  EXPECT_FALSE(next(false));
}

/// A spot without a place is not known to be the same as before.
TEST_F(Follows, NotIfASpotWasNeverFound) {
  const Vec2 place = at_px[7];
  at_px[7] = {NAN, NAN};
  EXPECT_TRUE(next(true));
  at_px[7] = place;
  EXPECT_FALSE(next(false));
}

}  // namespace
}  // namespace ovws::test
