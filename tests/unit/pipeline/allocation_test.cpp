/// The frame path allocates nothing once a plan is in use, whatever happens to the spots.
#include <gtest/gtest.h>

#include "tests/support/alloc_guard.hpp"
#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

struct AllocationCase {
  int workers = 0;
  int tracker = -1;  ///< TrackerKind, -1: the test's own
};

class Allocation : public ::testing::TestWithParam<AllocationCase> {};

TEST(AllocGuard, SeesAnAllocation) {
  AllocGuard guard;
  const auto made = std::make_unique<std::vector<int>>(100);
  EXPECT_GE(guard.allocations(), 2U);
}

std::unique_ptr<MeasurementPlan> plan_for(const AllocationCase& what, const SpotBench& bench,
                                          std::uint64_t id) {
  auto plan = bench.plan(id);
  if (what.tracker >= 0) {
    plan->tracker_kind = TrackerKind(what.tracker);
    plan->tracker = *make_tracker({plan->tracker_kind, 0.4}, plan->spots);
  }
  return plan;
}

TEST_P(Allocation, OfEveryStageIsNoneWhateverIsInTheImage) {
  PipelineRig rig(GetParam().workers);
  rig.use(plan_for(GetParam(), rig.bench, 1));
  rig.use(plan_for(GetParam(), rig.bench, 2));  // adopted on the way
  ASSERT_TRUE(rig.attach());
  const std::vector<std::shared_ptr<const Image<std::uint8_t>>> images{
      SpotBench::draw(rig.bench.model_px),
      SpotBench::draw(rig.bench.moved({{4, 0.1}}, {5.0, 2.0})),
      SpotBench::draw(rig.bench.model_px, {3, 11}),                  // retried
      SpotBench::draw(rig.bench.moved({{3, 0.3}}, {24.0, 20.0})),    // searched
      SpotBench::black(),                                            // searched in vain
      std::make_shared<Image<std::uint8_t>>(SpotBench::kSize, 10)};  // not the plan's size
  for (std::uint64_t id = 1; id <= 4 * images.size(); ++id) {
    rig.send(id, images[id % images.size()]);
    rig.pipeline.request_image();
    AllocGuard guard;
    rig.turn();
    FrameRecord* const record = rig.pipeline.next(0);
    if (record != nullptr) rig.pipeline.release(record);
    FrameRecord* const image = rig.pipeline.next_image(0);
    if (image != nullptr) rig.pipeline.release_image(image);
    EXPECT_EQ(guard.allocations(), 0U) << "frame " << id;
  }
  EXPECT_EQ(rig.count(Counter::frames_grabbed), 4 * images.size());
  EXPECT_GT(rig.count(Counter::acquisitions), 1U);
}

INSTANTIATE_TEST_SUITE_P(InlineAndThreaded, Allocation,
                         ::testing::Values(AllocationCase{0, -1}, AllocationCase{1, -1},
                                           AllocationCase{3, -1},
                                           AllocationCase{0, int(TrackerKind::centroid)},
                                           AllocationCase{0, int(TrackerKind::thresholded)},
                                           AllocationCase{2, int(TrackerKind::weighted)},
                                           AllocationCase{2, int(TrackerKind::lg)},
                                           AllocationCase{2, int(TrackerKind::fit)}));

}  // namespace
}  // namespace ovws::test
