/// Plans: what a plan is built from, which templates it gets, and when it is freed.
#include "daemon/ovwsd/sensor/plans.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/unit/pipeline/pipeline_rig.hpp"

namespace ovws {
namespace {

/// Finds no spot. Its mark lives as long as its plan.
struct MarkedTracker final : SpotTracker {
  TrackScratch make_scratch() const override { return {}; }
  SpotFix track(const ImageView&, Vec2, TrackScratch&) const override { return {}; }
  std::shared_ptr<int> mark = std::make_shared<int>();
};

class PlansTest : public testing::Test {
 protected:
  PlansTest() {
    auto slm = std::make_shared<ActiveSlm>();
    slm->hologram.slm = rig_.bench.slm;
    state_.sensor = rig_.bench.sensor;
    state_.tracking.tracker = TrackerKind::fit;
    state_.roi = {0, 0, test::SpotBench::kSize, test::SpotBench::kSize};
    state_.slm = slm;
    EXPECT_TRUE(renew_renderer(state_));
    auto reference = std::make_shared<Reference>();
    reference->t_taken_ns = 7;
    reference->positions_px = rig_.bench.model_px;
    reference->standard_error_px.assign(reference->positions_px.size(), Vec2{0.01, 0.01});
    bound_.reference = reference;
  }
  ~PlansTest() override { EXPECT_TRUE(rig_.detach()); }

  std::unique_ptr<MeasurementPlan> built() {
    auto plan = plans_.build(state_, bound_, 3);
    EXPECT_TRUE(plan);
    return plan ? std::move(*plan) : nullptr;
  }
  /// Activates a plan; its mark.
  std::weak_ptr<int> use_next() {
    auto tracker = std::make_unique<MarkedTracker>();
    std::weak_ptr<int> mark = tracker->mark;
    auto plan = built();
    plan->tracker = std::move(tracker);
    plans_.use(std::move(plan));
    return mark;
  }
  /// Templates without light, made for the present state.
  ActiveTemplates templates() {
    const auto plan = built();
    OperatingPoint point;
    point.estimates = state_.tracking.estimates;
    point.levels_dn.assign(plan->predicted_px.size(), 0.0);
    RenderedSpot dark;
    dark.light.setZero(1);
    const std::vector<RenderedSpot> spots(plan->predicted_px.size(), dark);
    return {{state_.sensor_epoch, bound_.reference->t_taken_ns, 0},
            std::make_shared<const FrameFit>(point, spots, plan->modes_j)};
  }
  void expect_no_templates(bool awaited, const char* why) {
    const auto plan = built();
    EXPECT_FALSE(plan->fit) << why;
    EXPECT_EQ(plan->awaits_templates, awaited) << why;
  }

  test::PipelineRig rig_;
  SensorState state_;
  Bound bound_;
  Plans plans_{rig_.pipeline, {rig_.bench.optics, rig_.bench.slm}};
};

TEST_F(PlansTest, APlanHasTheNextNumberAndIsBuiltFromTheState) {
  const auto first = built(), second = built();
  EXPECT_EQ(second->id, first->id + 1);
  EXPECT_EQ(first->hologram_id, 3U);
  EXPECT_EQ(first->sensor_epoch, state_.sensor_epoch);
  EXPECT_EQ(first->reference_px, bound_.reference->positions_px);
  EXPECT_EQ(first->predicted_px, bound_.reference->positions_px);
  state_.aberration = {{1, 0.5}};
  EXPECT_NE(built()->predicted_px, bound_.reference->positions_px);
}

TEST_F(PlansTest, PlansOfOneSensorShareWhatTheirHologramsDoNotChange) {
  const auto first = built();
  state_.aberration = {{4, 0.3}};
  ++state_.templates.made_for.sensor_epoch;
  const auto second = built();
  EXPECT_EQ(second->tracker, first->tracker);
  EXPECT_EQ(second->reconstructor, first->reconstructor);
  EXPECT_NE(second->predicted_px, first->predicted_px);
  state_.aberration.clear();
  EXPECT_EQ(built()->predicted_px, first->predicted_px);
}

/// `bind` copies a model reference each time.
TEST_F(PlansTest, PlansOfAModelReferenceShareThemToo) {
  auto model = std::make_shared<Reference>(*bound_.reference);
  model->source = ReferenceSource::model;
  bound_.reference = model;
  const auto first = built();
  bound_.reference = std::make_shared<Reference>(*model);
  EXPECT_EQ(built()->reconstructor, first->reconstructor);
}

TEST_F(PlansTest, AnotherSensorGetsPlansOfItsOwn) {
  const auto expect_another = [&, like = state_, bound = bound_](const char* what, auto change) {
    state_ = like;
    bound_ = bound;
    const auto before = built();
    change();
    const auto after = built();
    EXPECT_NE(after->reconstructor, before->reconstructor) << what;
    EXPECT_NE(after->tracker, before->tracker) << what;
  };
  expect_another("epoch", [&] { ++state_.sensor_epoch; });
  // An edit that fails after its plan was built leaves the epoch to the next edit.
  expect_another("charge at the same epoch", [&] {
    state_.sensor.charge = 2;
    EXPECT_TRUE(renew_renderer(state_));
  });
  expect_another("tracking", [&] { state_.tracking.tracker = TrackerKind::lg; });
  expect_another("region", [&] { state_.roi.x += 16; });
  expect_another("format", [&] { state_.format = PixelFormat::mono12; });
  expect_another("reference", [&] {
    auto newer = std::make_shared<Reference>(*bound_.reference);
    newer->t_taken_ns = 8;
    bound_.reference = newer;
  });
  expect_another("no reference", [&] { bound_.reference = nullptr; });
  expect_another("operator", [&] {
    const auto plan = built();
    auto made = std::make_shared<ModeOperator>();
    made->modes_j = plan->reconstructor->modes_j();
    made->slopes = plan->reconstructor->slopes();
    bound_.mode_operator = made;
  });
}

TEST_F(PlansTest, APlanGetsTheTemplatesOfItsStateAndNoOthers) {
  state_.templates = templates();
  const auto plan = built();
  EXPECT_EQ(plan->fit, state_.templates.fit);
  EXPECT_FALSE(plan->awaits_templates);
  const auto expect_none_with_another = [&, made_for = state_](const char* what, auto change) {
    state_ = made_for;
    change(state_);
    expect_no_templates(true, what);
  };
  expect_none_with_another("epoch", [](SensorState& now) { ++now.sensor_epoch; });
  expect_none_with_another("reference",
                           [](SensorState& now) { now.templates.made_for.reference_taken_ns = 8; });
  expect_none_with_another(
      "calibration", [](SensorState& now) { now.templates.made_for.calibration_taken_ns = 8; });
  expect_none_with_another("estimates", [](SensorState& now) { now.tracking.estimates = 2; });
  expect_none_with_another("modes", [](SensorState& now) { now.tracking.mode_count = 20; });
}

TEST_F(PlansTest, NoTemplatesAreAwaitedWherePositionsCount) {
  state_.templates = templates();
  state_.holder = Holder::job;
  expect_no_templates(false, "a job measures by positions");
  state_.holder = Holder::nobody;
  state_.templates.fit = nullptr;
  expect_no_templates(true, "not rendered yet");
  state_.templates.given_up = true;
  expect_no_templates(false, "given up");
  ++state_.sensor_epoch;
  expect_no_templates(true, "given up for an earlier epoch");
  state_.tracking.tracker = TrackerKind::lg;
  expect_no_templates(false, "another tracker");
  state_.tracking.tracker = TrackerKind::fit;
  bound_.reference = nullptr;
  expect_no_templates(false, "no reference");
}

TEST_F(PlansTest, AnotherTrackerUsesTemplatesOnlyInAClosedLoop) {
  state_.tracking.tracker = TrackerKind::lg;
  state_.templates = templates();
  EXPECT_EQ(built()->fit, nullptr) << "loop open";
  state_.holder = Holder::loop;
  EXPECT_EQ(built()->fit, state_.templates.fit);
  state_.templates.fit = nullptr;
  expect_no_templates(false, "it does not wait for them");
}

TEST_F(PlansTest, APlanIsFreedWhenALaterOneIsActiveAndNoFrameRefersToIt) {
  ASSERT_TRUE(rig_.attach());
  const auto first = use_next();
  FrameRecord* const record = rig_.measure(1, test::SpotBench::black());
  ASSERT_NE(record, nullptr);
  const auto second = use_next();
  plans_.retire();
  EXPECT_FALSE(first.expired()) << "no frame was measured by the second";
  test::Taken(rig_, rig_.measure(2, test::SpotBench::black()));
  plans_.retire();
  EXPECT_FALSE(first.expired()) << "the record refers to it";
  rig_.pipeline.release(record);
  rig_.turn();
  plans_.retire();
  EXPECT_TRUE(first.expired());
  EXPECT_FALSE(second.expired()) << "it is active";
}

}  // namespace
}  // namespace ovws
