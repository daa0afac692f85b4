/// With the trackers that the daemon runs: what was drawn is what comes out.
#include <gtest/gtest.h>

#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

struct RealTrackerCase {
  TrackerKind tracker;
  int charge;
  const char* name;
};

class RealTracker : public ::testing::TestWithParam<RealTrackerCase> {
 protected:
  RealTracker() : bench_(GetParam().charge) {
    auto plan = bench_.plan(1);
    plan->tracker_kind = GetParam().tracker;
    plan->tracker = *make_tracker({plan->tracker_kind, 0.4}, plan->spots);
    rig_.use(std::move(plan));
    EXPECT_TRUE(rig_.attach());
  }

  std::shared_ptr<const Image<std::uint8_t>> draw(const std::vector<Mode>& modes,
                                                  const std::vector<int>& dark = {}) const {
    const std::vector<Vec2> at = bench_.moved(modes);
    return bench_.sensor.charge == 0 ? SpotBench::draw(at, dark)
                                     : SpotBench::draw_vortices(at, dark);
  }

  SpotBench bench_;
  PipelineRig rig_;
};

TEST_P(RealTracker, FollowsAGrowingWavefrontAndRecoversIt) {
  for (std::uint64_t id = 1; id <= 8; ++id) {
    const double k = 0.1 * double(id);
    const std::vector<Mode> truth{{2, 0.3 * k}, {3, -0.6 * k}, {5, 0.4 * k}, {7, 0.1 * k}};
    Taken record(rig_, rig_.measure(id, draw(truth)));
    ASSERT_TRUE(record);
    EXPECT_EQ(record->tracked, 19);
    EXPECT_TRUE(record->valid);
    for (int m = 0; m < record->mode_count; ++m) {
      double expected = 0.0;
      for (const Mode& mode : truth) expected += mode.j == m + 1 ? mode.waves : 0.0;
      EXPECT_NEAR(double(record->coefficients[std::size_t(m)]), expected, 0.004) << "j " << m + 1;
    }
  }
  EXPECT_EQ(rig_.count(Counter::acquisitions), 1U);
}

TEST_P(RealTracker, FindsEverythingInAFirstImageThatIsFarFromTheModel) {
  const std::vector<Mode> truth{{1, 0.5}, {2, -0.4}, {3, 0.6}, {4, -0.4}};
  Taken record(rig_, rig_.measure(1, draw(truth)));
  EXPECT_EQ(record->tracked, 19);
  EXPECT_NEAR(double(record->coefficients[2]), 0.6, 0.004);
  EXPECT_NEAR(double(record->coefficients[3]), -0.4, 0.004);
}

TEST_P(RealTracker, MeasuresTheWavefrontWithTwoSpotsDarkAndTakesThemBack) {
  const std::vector<Mode> truth{{3, 0.2}, {4, 0.1}};
  Taken first(rig_, rig_.measure(1, draw(truth)));
  for (std::uint64_t id = 2; id <= 5; ++id) {
    Taken record(rig_, rig_.measure(id, draw(truth, {2, 9})));
    EXPECT_EQ(record->tracked, 17);
    EXPECT_TRUE(record->valid);
    EXPECT_NEAR(double(record->coefficients[2]), 0.2, 0.01);
  }
  Taken record(rig_, rig_.measure(6, draw(truth)));
  EXPECT_EQ(record->tracked, 19);
  EXPECT_EQ(rig_.count(Counter::acquisitions), 1U);
}

TEST_P(RealTracker, ClaimsNothingInABlackImage) {
  Taken first(rig_, rig_.measure(1, draw({})));
  for (std::uint64_t id = 2; id <= 20; ++id) {
    Taken record(rig_, rig_.measure(id, SpotBench::black()));
    EXPECT_EQ(record->tracked, 0);
    EXPECT_FALSE(record->valid);
  }
}

INSTANTIATE_TEST_SUITE_P(Trackers, RealTracker,
                         ::testing::Values(RealTrackerCase{TrackerKind::lg, 1, "lg_charge_1"},
                                           RealTrackerCase{TrackerKind::lg, 0, "lg_charge_0"},
                                           RealTrackerCase{TrackerKind::thresholded, 0,
                                                           "thresholded"},
                                           RealTrackerCase{TrackerKind::weighted, 0, "weighted"},
                                           RealTrackerCase{TrackerKind::fit, 1, "fit_charge_1"},
                                           RealTrackerCase{TrackerKind::fit, 0, "fit_charge_0"}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace ovws::test
