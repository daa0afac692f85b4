/// Frames with the spots of two light sources: each is measured alone, and disturbs the other in
/// nothing.
#include <gtest/gtest.h>

#include "tests/support/alloc_guard.hpp"
#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws::test {
namespace {

constexpr Vec2 kMain{140.0, 256.0}, kBeam{372.0, 256.0};
constexpr double kShrunk = 0.4;  // so that both lattices have room in the image
constexpr double kRadiusPx = 115.0;

class TwoSources : public ::testing::TestWithParam<int> {
 protected:
  TwoSources() : rig_(GetParam(), 64, 8, 1) {
    auto plan = plan_at(kMain);
    auto beam = plan_at(kBeam);
    beam->beam = "b";
    plan->beams.push_back(std::move(beam));
    rig_.use(std::move(plan));
    if (const auto attached = rig_.attach(); !attached) ADD_FAILURE();
  }

  std::vector<Vec2> places(Vec2 middle, const std::vector<Mode>& modes = {},
                           Vec2 shift_px = {}) const {
    const std::vector<Vec2> moved = rig_.bench.moved(modes, shift_px);
    std::vector<Vec2> at = rig_.bench.model_px;
    const Vec2 centre{255.5, 255.5};
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = middle + kShrunk * (at[i] - centre) + (moved[i] - rig_.bench.model_px[i]);
    }
    return at;
  }

  std::unique_ptr<MeasurementPlan> plan_at(Vec2 middle) const {
    auto plan = rig_.bench.plan(1);
    plan->predicted_px = plan->reference_px = places(middle);
    plan->reconstructor =
        std::make_unique<Reconstructor>(rig_.bench.slopes, plan->modes_j, plan->reference_px);
    plan->region = Disc{middle, kRadiusPx};
    return plan;
  }

  static std::shared_ptr<const Image<std::uint8_t>> both(std::vector<Vec2> main,
                                                         const std::vector<Vec2>& beam) {
    main.insert(main.end(), beam.begin(), beam.end());
    return SpotBench::draw(main);
  }

  PipelineRig rig_;
};

void expect_mode(const FrameRecord& record, int j, double waves) {
  EXPECT_TRUE(record.valid);
  EXPECT_EQ(record.tracked, 19);
  for (int k = 0; k < record.mode_count; ++k) {
    const double expected = record.plan->modes_j[std::size_t(k)] == j ? waves : 0.0;
    EXPECT_NEAR(double(record.coefficients[std::size_t(k)]), expected, 0.01) << "mode " << k;
  }
}

TEST_P(TwoSources, EachHasItsOwnModesInTheSameFrame) {
  Taken(rig_, rig_.measure(1, both(places(kMain), places(kBeam))));
  Taken frame(rig_, rig_.measure(2, both(places(kMain, {{4, 0.02}}), places(kBeam, {{3, -0.03}}))));
  ASSERT_EQ(frame->beams().size(), 1U);
  const FrameRecord& beam = *frame->beams()[0];
  expect_mode(*frame, 4, 0.02);
  expect_mode(beam, 3, -0.03);
  EXPECT_EQ(beam.plan->beam, "b");
  EXPECT_EQ(beam.frame.frame_id, 2U);
  EXPECT_EQ(beam.number, frame->number);
}

TEST_P(TwoSources, ADarkOneIsLostAndNotFoundInTheOthersSpots) {
  Taken(rig_, rig_.measure(1, both(places(kMain), places(kBeam))));
  for (std::uint64_t id = 2; id < 40; ++id) {  // searched several times
    Taken frame(rig_, rig_.measure(id, SpotBench::draw(places(kMain))));
    expect_mode(*frame, 0, 0.0);
    EXPECT_FALSE(frame->beams()[0]->valid);
    EXPECT_EQ(frame->beams()[0]->tracked, 0);
  }
  for (std::uint64_t id = 40; id < 60; ++id) {
    Taken(rig_, rig_.measure(id, both(places(kMain), places(kBeam))));
  }
  Taken frame(rig_, rig_.measure(60, both(places(kMain), places(kBeam))));
  expect_mode(*frame->beams()[0], 0, 0.0);
}

TEST_P(TwoSources, AreFoundWithoutHistoryInTheirRegions) {
  const Vec2 shift{17.0, -15.0};
  Taken frame(rig_,
              rig_.measure(1, both(places(kMain, {}, shift), places(kBeam, {}, -1.0 * shift))));
  EXPECT_EQ(frame->tracked, 19);
  EXPECT_EQ(frame->beams()[0]->tracked, 19);
  for (int i = 0; i < 19; ++i) {
    const auto spot = std::size_t(i);
    EXPECT_NEAR(double(frame->spots[spot].x), places(kMain, {}, shift)[spot].x, 0.5);
    EXPECT_NEAR(double(frame->beams()[0]->spots[spot].x), places(kBeam, {}, -1.0 * shift)[spot].x,
                0.5);
  }
}

TEST_P(TwoSources, CostNoAllocation) {
  const auto lit = both(places(kMain), places(kBeam)), dark = SpotBench::draw(places(kMain));
  for (std::uint64_t id = 1; id <= 24; ++id) {
    rig_.send(id, id % 6 < 3 ? lit : dark);
    AllocGuard guard;
    rig_.turn();
    FrameRecord* const record = rig_.pipeline.next(0);
    if (record != nullptr) rig_.pipeline.release(record);
    EXPECT_EQ(guard.allocations(), 0U) << "frame " << id;
  }
}

INSTANTIATE_TEST_SUITE_P(InlineAndThreaded, TwoSources, ::testing::Values(0, 1, 3));

}  // namespace
}  // namespace ovws::test
