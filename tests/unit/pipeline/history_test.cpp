/// Tracks follow the spots, survive short losses, and trigger a whole-image search when they are
/// lost.
#include <gtest/gtest.h>

#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

/// A rig in which frame 0 has been measured with the spots as the model says.
struct Tracking : PipelineRig {
  explicit Tracking(int workers = 0) : PipelineRig(workers) {
    use(bench.plan(1));
    EXPECT_TRUE(attach());
    still = SpotBench::draw(bench.model_px);
    EXPECT_EQ(tracked(0, still), 19);
    EXPECT_EQ(count(Counter::acquisitions), 1U);
  }

  int tracked(std::uint64_t id, const std::shared_ptr<const Image<std::uint8_t>>& image) {
    Taken record(*this, measure(id, image));
    EXPECT_TRUE(record);
    return record ? record->tracked : -1;
  }

  /// Hologram `id` is presented just before frame `frame_id`, and settled for it.
  void show_before(std::uint64_t frame_id, std::uint64_t id) {
    const std::int64_t settled = arrival_ns(frame_id) - 2 * kMs;
    show({id, 1, settled - kMs, settled}, {id - 1, 1, 0, kMs});
  }

  /// A plan for spots that a hologram moved to `predicted_px`.
  void use_predicting(std::uint64_t id, const std::vector<Vec2>& predicted_px,
                      std::uint64_t hologram_id = 2) {
    auto next = bench.plan(id);
    next->predicted_px = predicted_px;
    next->hologram_id = hologram_id;
    use(std::move(next));
  }

  std::shared_ptr<const Image<std::uint8_t>> still;
};

TEST(History, SpotsAreFollowedFartherThanAnyWindowReaches) {
  Tracking rig;
  for (std::uint64_t id = 1; id <= 12; ++id) {
    const auto image = SpotBench::draw(rig.bench.moved({}, {0.0, 6.0 * double(id)}));
    Taken record(rig, rig.measure(id, image));
    ASSERT_EQ(record->tracked, 19);
    EXPECT_NEAR(double(record->spots[4].y), rig.bench.model_px[4].y + 6.0 * double(id), 0.5);
  }
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
}

TEST(History, AStepOfTheHologramIsFollowedByWhatThePlanPredicts) {
  Tracking rig;
  const std::vector<Vec2> moved = rig.bench.moved({{4, 0.9}}, {35.0, 0.0});
  rig.use_predicting(2, moved);
  rig.show_before(1, 2);
  EXPECT_EQ(rig.tracked(1, SpotBench::draw(moved)), 19);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
}

TEST(History, APlanThatComesBeforeItsHologramDoesNotMoveTheTracks) {
  Tracking rig;
  const std::vector<Vec2> moved = rig.bench.moved({}, {35.0, 20.0});
  rig.use_predicting(2, moved);
  EXPECT_EQ(rig.tracked(1, rig.still), 19);
  EXPECT_EQ(rig.tracked(2, rig.still), 19);
  rig.show_before(3, 2);
  EXPECT_EQ(rig.tracked(3, SpotBench::draw(moved)), 19);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
}

TEST(History, NoFrameIsSettledBeforeThePlanThatPredictsItsHologram) {
  Tracking rig;
  const std::vector<Vec2> moved = rig.bench.moved({{4, 0.9}}, {35.0, 0.0});
  const auto image = SpotBench::draw(moved);
  rig.show_before(1, 2);
  Taken early(rig, rig.measure(1, image));
  EXPECT_TRUE(early->still);
  EXPECT_FALSE(early->settled);
  EXPECT_LT(early->tracked, 19);
  rig.use_predicting(2, moved);
  Taken record(rig, rig.measure(2, image));
  EXPECT_TRUE(record->settled);
  EXPECT_EQ(record->tracked, 19);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
}

TEST(History, ANewReferenceDoesNotMoveTheTracksEither) {
  Tracking rig;
  const Vec2 misaligned{18.0, -12.0};  // reached step by step from where the model has the spots
  for (std::uint64_t id = 1; id <= 3; ++id) {
    const auto image = SpotBench::draw(rig.bench.moved({}, (double(id) / 3.0) * misaligned));
    ASSERT_EQ(rig.tracked(id, image), 19);
  }
  const std::vector<Vec2> reference = rig.bench.moved({}, misaligned);
  rig.use_predicting(2, reference, 1);  // for the hologram that is shown
  EXPECT_EQ(rig.tracked(4, SpotBench::draw(reference)), 19);
  const std::vector<Vec2> moved = rig.bench.moved({{5, 0.5}}, misaligned + Vec2{30.0, 0.0});
  rig.use_predicting(3, moved, 2);
  rig.show_before(5, 2);
  EXPECT_EQ(rig.tracked(5, SpotBench::draw(moved)), 19);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
}

TEST(History, FramesWhileTheHologramChangesDoNotSpoilIt) {
  Tracking rig;
  const std::vector<Vec2> moved = rig.bench.moved({}, {30.0, 0.0});
  rig.use_predicting(2, moved);
  rig.show({2, 1, rig.arrival_ns(0) + 1, rig.arrival_ns(4)}, {1, 1, 0, kMs});
  for (std::uint64_t id = 1; id <= 4; ++id) {  // in between: nothing, and spots on their way
    Taken record(rig, rig.measure(id, id % 2 == 0 ? SpotBench::black()
                                                  : SpotBench::draw(rig.bench.moved(
                                                        {}, {5.0 * double(id), 0.0}))));
    EXPECT_FALSE(record->settled);
  }
  EXPECT_EQ(rig.tracked(5, SpotBench::draw(moved)), 19);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
}

TEST(History, ASpotThatReturnsIsFoundFromItsNeighbours) {
  Tracking rig;
  for (std::uint64_t id = 1; id <= 10; ++id) {  // dark while everything moves farther than a window
    const auto at = rig.bench.moved({{4, 0.02 * double(id)}}, {4.0 * double(id), 0.0});
    Taken record(rig, rig.measure(id, SpotBench::draw(at, {0, 9})));
    EXPECT_EQ(record->tracked, 17);
    EXPECT_FALSE(record->spots[0].found());
    EXPECT_FALSE(record->spots[9].found());
    EXPECT_TRUE(record->valid);
  }
  const auto at = rig.bench.moved({{4, 0.22}}, {44.0, 0.0});
  Taken record(rig, rig.measure(11, SpotBench::draw(at)));
  EXPECT_EQ(record->tracked, 19);
  EXPECT_NEAR(double(record->spots[0].x), at[0].x, 0.5);
  EXPECT_NEAR(double(record->spots[9].x), at[9].x, 0.5);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
  EXPECT_EQ(rig.count(Counter::spots_lost), 20U);
}

TEST(History, ASpotThatBlinksIsFoundWhereItWasHoweverRoughTheWavefront) {
  Tracking rig;
  const std::vector<Mode> rough{{7, 0.3}, {8, -0.2}, {11, 0.15}};
  rig.use_predicting(2, rig.bench.moved(rough));
  rig.show_before(1, 2);
  auto referring_to_model = rig.bench.plan(3);  // neighbours now speak of the model's positions
  referring_to_model->hologram_id = 2;
  EXPECT_EQ(rig.tracked(1, SpotBench::draw(rig.bench.moved(rough))), 19);
  rig.use(std::move(referring_to_model));
  for (int blinking = 0; blinking < 19; ++blinking) {
    const auto id = std::uint64_t(10 + 3 * blinking);
    const auto at = rig.bench.moved(rough, {0.5 * blinking, 0.0});
    EXPECT_EQ(rig.tracked(id, SpotBench::draw(at, {blinking})), 18);
    EXPECT_EQ(rig.tracked(id + 1, SpotBench::draw(at, {blinking})), 18);
    EXPECT_EQ(rig.tracked(id + 2, SpotBench::draw(at)), 19) << "spot " << blinking;
  }
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U);
}

TEST(History, AJumpOfAllSpotsIsSearchedAtOnce) {
  Tracking rig;
  const auto at = rig.bench.moved({{3, 0.05}}, {22.0, -32.0});
  Taken record(rig, rig.measure(1, SpotBench::draw(at)));
  ASSERT_EQ(record->tracked, 19);
  for (int i = 0; i < 19; ++i) {
    EXPECT_NEAR(double(record->spots[std::size_t(i)].x), at[std::size_t(i)].x, 0.5);
    EXPECT_NEAR(double(record->spots[std::size_t(i)].y), at[std::size_t(i)].y, 0.5);
  }
  EXPECT_EQ(rig.count(Counter::acquisitions), 2U);
}

TEST(History, ABlackImageIsSearchedEverMoreSeldom) {
  Tracking rig;
  EXPECT_EQ(rig.tracked(1, rig.still), 19);
  const auto black = SpotBench::black();
  std::vector<std::uint64_t> searched;
  for (std::uint64_t id = 0; id < 50; ++id) {
    const std::uint64_t before = rig.count(Counter::acquisitions);
    Taken record(rig, rig.measure(id + 2, black));
    EXPECT_EQ(record->tracked, 0);
    EXPECT_FALSE(record->valid);
    if (rig.count(Counter::acquisitions) > before) searched.push_back(id);
  }
  EXPECT_EQ(searched, (std::vector<std::uint64_t>{0, 1, 3, 7, 15, 31, 47}));
  std::uint64_t id = 52;
  while (id < 71 && rig.tracked(id, rig.still) != 19) ++id;
  EXPECT_LE(id, 52U + 16U);
  EXPECT_EQ(rig.tracked(id + 1, rig.still), 19);
  const std::uint64_t before = rig.count(Counter::acquisitions);
  EXPECT_EQ(rig.tracked(id + 2, SpotBench::draw(rig.bench.moved({}, {25.0, 20.0}))), 19);
  EXPECT_EQ(rig.count(Counter::acquisitions), before + 1);  // at once again
}

TEST(History, AnotherExposureOrGainIsSearchedAtOnce) {
  Tracking rig;
  std::uint64_t id = 1;
  const auto lose = [&] {  // the next search is 16 frames away
    for (int k = 0; k < 32; ++k) EXPECT_EQ(rig.tracked(id++, SpotBench::black()), 0);
    EXPECT_EQ(rig.tracked(id++, rig.still), 0);
  };
  lose();
  rig.applied.exposure_us = 500.0;
  rig.settings.write(rig.applied);
  EXPECT_EQ(rig.tracked(id++, rig.still), 19);
  lose();
  rig.applied.gain_db = 6.0;
  rig.settings.write(rig.applied);
  EXPECT_EQ(rig.tracked(id++, rig.still), 19);
}

TEST(History, ManySpotsDarkForGoodDoNotCostASearchEachFrame) {
  Tracking rig;
  EXPECT_EQ(rig.tracked(1, rig.still), 19);
  const auto partly = SpotBench::draw(rig.bench.model_px, {0, 1, 2, 3, 4, 5});
  for (std::uint64_t id = 2; id <= 49; ++id) EXPECT_EQ(rig.tracked(id, partly), 13);
  EXPECT_EQ(rig.count(Counter::acquisitions), 1U + 7U);
}

TEST(History, WithoutASettledFrameNothingIsSearchedOrClaimed) {
  PipelineRig rig;
  rig.use(rig.bench.plan(1));
  rig.show({1, 1, 0, ShownHologram::kNever}, {});
  ASSERT_TRUE(rig.attach());
  Taken record(rig, rig.measure(1, SpotBench::draw(rig.bench.model_px)));
  EXPECT_EQ(record->tracked, 0);
  EXPECT_EQ(rig.count(Counter::acquisitions), 0U);
}

TEST(History, AnotherSensorBeginsWithoutHistory) {
  Tracking rig;
  auto next = rig.bench.plan(2);
  next->sensor_epoch = next->hologram_id = 2;
  rig.use(std::move(next));
  Taken unsettled(rig, rig.measure(1, rig.still));
  EXPECT_FALSE(unsettled->settled);
  EXPECT_EQ(unsettled->tracked, 0);
  rig.show({2, 2, rig.arrival_ns(1), rig.arrival_ns(1) + kMs}, {1, 1, 0, kMs});
  EXPECT_EQ(rig.tracked(2, rig.still), 19);
  EXPECT_EQ(rig.count(Counter::acquisitions), 2U);
}

void expect_no_spot_shared(const FrameRecord& record) {
  for (int i = 0; i < record.spot_count; ++i) {
    for (int k = i + 1; k < record.spot_count; ++k) {
      const SpotFix& a = record.spots[std::size_t(i)];
      const SpotFix& b = record.spots[std::size_t(k)];
      if (!a.found() || !b.found()) continue;
      EXPECT_GT(std::hypot(a.x - b.x, a.y - b.y), 10.0F)
          << "frame " << record.frame.frame_id << ": " << i << " and " << k;
    }
  }
}

TEST(History, TwoSubaperturesThatWalkIntoOneAnotherDoNotShareASpot) {
  Tracking rig;
  std::vector<Vec2> at = rig.bench.model_px;
  const Vec2 step = 0.125 * (at[10] - at[9]);
  for (std::uint64_t id = 1; id <= 8; ++id) {
    at[9] = at[9] + step;
    const std::vector<int> dark = id == 8 ? std::vector<int>{9} : std::vector<int>{};
    Taken record(rig, rig.measure(id, SpotBench::draw(at, dark)));
    expect_no_spot_shared(*record);
  }
}

TEST(History, ADarkSubapertureDoesNotTakeTheSpotThatCameToItsPlace) {
  Tracking rig;
  // Without a reference: no wavefront moves one spot alone, so the modes would refuse it.
  auto plan = rig.bench.plan(2);
  const Reconstructor& modes = *plan->reconstructor;
  plan->reconstructor =
      std::make_unique<Reconstructor>(modes.slopes(), modes.modes_j(), std::vector<Vec2>{});
  rig.use(std::move(plan));
  std::vector<Vec2> at = rig.bench.model_px;
  const Vec2 step = 0.125 * (at[9] - at[10]);
  for (std::uint64_t id = 1; id <= 8; ++id) {
    at[10] = at[10] + step;
    Taken record(rig, rig.measure(id, SpotBench::draw(at, {9})));
    expect_no_spot_shared(*record);
    EXPECT_FALSE(record->spots[9].found()) << "frame " << id;
    EXPECT_TRUE(record->spots[10].found()) << "frame " << id;
  }
}

}  // namespace
}  // namespace ovws::test
