/// Plans are swapped whole between two frames, and may be destroyed once nobody touches them.
#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

TEST(Plans, BeforeAnyPlanEveryIdMayStillBeInUse) {
  PipelineRig rig;
  EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 0U);
}

TEST(Plans, ANewPlanMeasuresFromTheNextFrameOn) {
  PipelineRig rig;
  ASSERT_TRUE(rig.attach());
  rig.use(rig.bench.plan(1));
  const auto still = SpotBench::draw(rig.bench.model_px);
  Taken first(rig, rig.measure(1, still));
  EXPECT_EQ(first->plan->id, 1U);
  rig.use(rig.bench.plan(2));
  EXPECT_EQ(first->plan->id, 1U);
  Taken second(rig, rig.measure(2, still));
  EXPECT_EQ(second->plan->id, 2U);
  EXPECT_EQ(second->tracked, 19);
}

TEST(Plans, AnOldPlanIsInUseUntilItsLastRecordWasReleased) {
  for (const int workers : {0, 2}) {
    PipelineRig rig(workers);
    ASSERT_TRUE(rig.attach());
    rig.use(rig.bench.plan(5));
    const auto still = SpotBench::draw(rig.bench.model_px);
    FrameRecord* const old_record = rig.measure(1, still);
    EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 5U);
    rig.use(rig.bench.plan(6));
    EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 5U);
    Taken(rig, rig.measure(2, still));
    EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 5U);  // the publisher still reads it
    rig.pipeline.release(old_record);
    rig.turn();
    EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 6U);
  }
}

TEST(Plans, AFrameStillBeingTrackedKeepsItsPlan) {
  PipelineRig rig(1);
  ASSERT_TRUE(rig.attach());
  rig.use(rig.bench.plan(1));
  rig.send(1, SpotBench::draw(rig.bench.model_px));
  rig.pipeline.acquisition().do_work();
  rig.use(rig.bench.plan(2));
  rig.pipeline.acquisition().do_work();
  EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 1U);
  rig.turn_workers();
  Taken(rig, rig.pipeline.next(0));
  rig.turn();
  EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 2U);
}

TEST(Plans, WithoutACameraPlansComeOutOfUseToo) {
  PipelineRig rig;
  for (std::uint64_t id = 1; id <= 3; ++id) {
    rig.use(rig.bench.plan(id));
    rig.turn();
    EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), id);
  }
}

TEST(Plans, APlanOutOfUseMayBeDestroyedAtOnce) {
  PipelineRig rig;
  ASSERT_TRUE(rig.attach());
  const auto still = SpotBench::draw(rig.bench.model_px);
  for (std::uint64_t id = 1; id <= 10; ++id) {
    rig.use(rig.bench.plan(id));
    Taken record(rig, rig.measure(id, still));
    EXPECT_EQ(record->tracked, 19);
    const std::uint64_t oldest = rig.pipeline.oldest_plan_in_use();
    std::erase_if(rig.plans, [&](const auto& plan) { return plan->id < oldest; });
  }
  EXPECT_LE(rig.plans.size(), 2U);
}

TEST(Plans, TakingThePlanAwayEndsMeasuringAndFreesIt) {
  PipelineRig rig;
  ASSERT_TRUE(rig.attach());
  rig.use(rig.bench.plan(1));
  const auto still = SpotBench::draw(rig.bench.model_px);
  Taken(rig, rig.measure(1, still));
  rig.pipeline.use_plan(nullptr);
  EXPECT_EQ(rig.measure(2, still), nullptr);
  EXPECT_EQ(rig.count(Counter::frames_unplanned), 1U);
  EXPECT_EQ(rig.pipeline.oldest_plan_in_use(), 2U);
  rig.use(rig.bench.plan(2));
  EXPECT_EQ(Taken(rig, rig.measure(3, still))->tracked, 19);
}

TEST(Plans, AnIdThatDoesNotIncreaseIsOurOwnBug) {
  PipelineRig rig;
  rig.use(rig.bench.plan(4));
  const auto again = rig.bench.plan(4);
  EXPECT_THROW(rig.pipeline.use_plan(again.get()), std::logic_error);
}

TEST(Plans, APlanThatIsNotWholeIsOurOwnBug) {
  PipelineRig rig;
  auto plan = rig.bench.plan(1);
  plan->tracker.reset();
  EXPECT_THROW(rig.pipeline.use_plan(plan.get()), std::logic_error);
}

}  // namespace
}  // namespace ovws::test
