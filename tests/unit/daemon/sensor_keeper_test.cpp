/// SensorKeeper: which holograms it shows, and who may change the sensor, with a fake display. This
/// program's own open_display replaces the driver table's.
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>

#include "daemon/ovwsd/devices/driver_table.hpp"
#include "tests/support/time.hpp"
#include "tests/unit/daemon/keeper_bench.hpp"

namespace ovws {

Result<std::unique_ptr<Display>> open_display(const SlmConfig& config) {
  if (!test::screen->there) return fail(Errc::unavailable, "slm", "it was pulled out");
  return std::make_unique<test::PlayedDisplay>(config);
}
Result<std::unique_ptr<Camera>> open_camera(const CameraConfig&) {
  return fail(Errc::unavailable, "camera", "there is none");
}

namespace {

using test::Keeper, test::kNotOpened;

TEST_F(Keeper, TheDisplayCountsAsOpenOnceItShowsTheFirstHologram) {
  for (int wait = 0; wait < 1000 && parts_->opened_with_id == kNotOpened; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(parts_->opened_with_id, keeper_->snapshot()->hologram_id);
}

TEST_F(Keeper, ShowsWhatItAnswers) {
  const std::uint64_t before = keeper_->snapshot()->plan_id;
  const auto now = edit(set_aberration({{4, 0.2}}));
  ASSERT_TRUE(now) << now.error().reason;
  EXPECT_EQ((*now)->aberration, (std::vector<Mode>{{4, 0.2}}));
  EXPECT_GT((*now)->plan_id, before);
  const Image<std::uint8_t> with = screen_.picture();
  const auto cleared = edit(set_aberration({}));
  ASSERT_TRUE(cleared);
  EXPECT_GT((*cleared)->hologram_id, (*now)->hologram_id);
  EXPECT_NE(screen_.picture().pixels, with.pixels);
}

TEST_F(Keeper, LeavesAllAsItWasWhereAChangeCannotBe) {
  const SensorView before = keeper_->snapshot();
  EXPECT_FALSE(edit([](SensorEdit& edit) -> Result<void> {
    edit.state.aberration = {{4, 1.0}};
    edit.knowledge.references.clear();
    return fail(Errc::refused, "", "no");
  }));
  EXPECT_FALSE(edit(set_aberration({{4, 900.0}}))) << "the SLM cannot sample it";
  SensorSet close;
  close.put(&SensorConfig::spacing, 0.001);
  const auto refused = edit(set_sensor(close));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "sensor.spacing");
  EXPECT_EQ(keeper_->snapshot(), before);
}

TEST_F(Keeper, ChangesNothingWithoutADisplay) {
  ASSERT_TRUE(edit(set_aberration({{4, 0.1}})));
  const SensorView before = keeper_->snapshot();
  screen_.there = false;
  EXPECT_FALSE(edit(set_aberration({{4, 0.2}})));
  EXPECT_EQ(keeper_->snapshot(), before);
}

TEST_F(Keeper, WhatAJobShowsIsTakenBackWhenItsTurnEnds) {
  ASSERT_TRUE(edit(set_aberration({{3, 0.1}})));
  const Image<std::uint8_t> user = screen_.picture();
  turn_to(Holder::job);
  EXPECT_EQ(keeper_->holder(), Holder::job);
  const auto shown = edit(show_request({{{5, 0.3}}, nullptr}));
  ASSERT_TRUE(shown);
  EXPECT_EQ((*shown)->aberration, (std::vector<Mode>{{5, 0.3}}));
  turn_to(Holder::nobody);
  EXPECT_EQ(keeper_->holder(), Holder::nobody);
  EXPECT_EQ(keeper_->snapshot()->aberration, (std::vector<Mode>{{3, 0.1}}));
  EXPECT_EQ(screen_.picture().pixels, user.pixels);
}

TEST_F(Keeper, AJobThatEndsWithoutADisplayIsTakenBackAllTheSame) {
  turn_to(Holder::job);
  ASSERT_TRUE(edit(show_request({{{5, 0.3}}, nullptr})));
  screen_.there = false;
  turn_to(Holder::nobody);
  EXPECT_TRUE(keeper_->snapshot()->aberration.empty());
}

TEST_F(Keeper, WhatTheLoopShowsStaysWhenItsTurnEnds) {
  turn_to(Holder::loop);
  ASSERT_TRUE(edit(set_correction({{3, 0.1}})));
  turn_to(Holder::nobody);
  EXPECT_EQ(keeper_->snapshot()->correction, (std::vector<Mode>{{3, 0.1}}));
}

TEST_F(Keeper, DropsItsQuestionsWhenItsThreadEnds) {
  keeper_->ask_in_spare_time([](const SensorEdit&) { test::skip(std::chrono::milliseconds(20)); });
  keeper_->do_work();
  test::skip(-std::chrono::hours(1));  // the next one is not due, however busy the machine is
  const auto caller = std::make_shared<int>();
  keeper_->ask_in_spare_time([caller](const SensorEdit&) {});
  keeper_->do_work();
  EXPECT_EQ(caller.use_count(), 2) << "it waits";
  keeper_->on_close();
  EXPECT_EQ(caller.use_count(), 1);
  test::skip(std::chrono::hours(1));
}

TEST_F(Keeper, QuestionsLeaveItsTimeToChanges) {
  constexpr int kMany = 200;
  int changes = 0, answers = 0;
  for (int k = 0; k < kMany; ++k) {
    keeper_->ask_in_spare_time([&](const SensorEdit&) {
      ++answers;
      test::skip(std::chrono::milliseconds(20));
    });
    keeper_->after_changes([&] { ++changes; });
    keeper_->do_work();
    keeper_->do_work();
  }
  EXPECT_EQ(changes, kMany);
  EXPECT_GT(answers, 0);
  EXPECT_LT(answers, kMany / 2);  // once in 180 ms
  for (int k = 0; k < kMany; ++k) {
    test::skip(std::chrono::milliseconds(500));
    keeper_->do_work();
  }
  EXPECT_EQ(answers, kMany);
}

TEST_F(Keeper, AReferenceOutlivesARestartUntilItIsForgotten) {
  ASSERT_FALSE(keeper_->snapshot()->reference);
  const auto referenced = edit(use_model_reference());
  ASSERT_TRUE(referenced);
  ASSERT_TRUE((*referenced)->reference);
  EXPECT_EQ((*referenced)->reference->source, ReferenceSource::model);
  EXPECT_EQ(sha256_of(parts_->library, *(*referenced)->reference).size(), 64U);
  end();
  start();
  ASSERT_TRUE(keeper_->snapshot()->reference);
  const auto forgotten = edit(forget_reference());
  ASSERT_TRUE(forgotten);
  EXPECT_FALSE((*forgotten)->reference);
  end();
  start();
  EXPECT_FALSE(keeper_->snapshot()->reference);
}

/// Its rotation is not known before that, and modes would be valid and wrong.
TEST_F(Keeper, AnArrayHasNoReferenceBeforeARegistrationHasFoundIt) {
  end();
  config_ = Config{};
  config_.modulator = Modulator::fixed;
  config_.state.directory = folder_;
  config_.optics.focal_length_mm = 5.2;
  config_.sensor.charge = 0;
  config_.sensor.grid = Grid::square;
  config_.array.pupil_mm = 1.35;
  config_.tracking.tracker = TrackerKind::lg;
  config_.camera.settings.roi = {0, 0, 400, 400};
  use_modulator(config_);
  start();
  std::vector<Vec2> places;
  Reference before;  // as if a version without this rule had made it
  ASSERT_TRUE(edit([&](SensorEdit& edit) -> Result<void> {
    places = model_positions(edit.state, edit.bench.optics);
    before.key = key_of(edit.state, edit.knowledge, edit.bench.optics);
    before.source = ReferenceSource::model;
    before.origin = std::make_shared<const nlohmann::json>(
        make_origin({before.key, {}, std::nullopt, std::nullopt, nullptr}));
    before.positions_px = places;
    before.standard_error_px.assign(places.size(), {});
    add_items<Reference>(edit.knowledge, {std::make_shared<const Reference>(before)});
    return {};
  }));
  SpotAverage given;
  given.frames = 1;
  given.mean_px = places;
  given.standard_error_px.assign(places.size(), {0.01, 0.01});
  given.found.assign(places.size(), 1);
  const TakenReference taken{{}, given, {}, nullptr, config_.camera.settings};
  const auto spots = std::make_shared<std::vector<ReferenceSpots>>();
  const auto changes = [&] {
    return std::vector<SensorChange>{use_reference(keeper_->snapshot()->sensor_epoch, taken, spots),
                                     use_model_reference(), use_given_reference(given),
                                     use_saved_reference(before)};
  };
  EXPECT_FALSE(keeper_->snapshot()->reference);
  for (const SensorChange& change : changes()) {
    const auto refused = edit(change);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::refused);
    EXPECT_NE(refused.error().reason.find("call registration.run first"), std::string::npos)
        << refused.error().reason;
  }
  EXPECT_FALSE(keeper_->snapshot()->reference);
  ASSERT_TRUE(edit([&](SensorEdit& edit) -> Result<void> {
    Registration found;
    found.array.lenslets = edit.state.sensor.lenslets;
    found.array.pupil_diameter_px = edit.state.sensor.pupil_diameter_px;
    found.array.subapertures_across = edit.state.sensor.subapertures_across;
    found.base_px = {199.5, 199.5};
    found.px_per_cycle = PxPerCycle(edit.state.sensor.lenslets.px_per_cycle);
    return use_registration(found)(edit);
  }));
  for (const SensorChange& change : changes()) {
    const auto used = edit(change);
    ASSERT_TRUE(used) << used.error().reason;
    EXPECT_TRUE((*used)->reference);
  }
}

TEST_F(Keeper, ForgettingWhatWasNotMeasuredChangesNoPlan) {
  const SensorView before = keeper_->snapshot();
  ASSERT_TRUE(edit(forget_lut()));
  ASSERT_TRUE(edit(forget_flatness()));
  EXPECT_EQ(keeper_->snapshot(), before);
}

TEST_F(Keeper, AReferenceIsOfItsSensorAndItsRegion) {
  ASSERT_TRUE(edit(use_model_reference()));
  SensorSet other;
  other.put(&SensorConfig::charge, 0);
  const auto changed = edit(set_sensor(other));
  ASSERT_TRUE(changed) << changed.error().reason;
  EXPECT_FALSE((*changed)->reference);
  EXPECT_EQ((*changed)->obstacle.reason, "") << "another sensor was chosen";
  (void)events_of("reference");
  other.put(&SensorConfig::charge, 1);
  ASSERT_TRUE(edit(set_sensor(other)));
  EXPECT_TRUE(keeper_->snapshot()->reference);
  CameraSettings camera = config_.camera.settings;
  const std::uint64_t epoch = keeper_->snapshot()->sensor_epoch;
  camera.roi = {16, 0, 640, 816};
  keeper_->camera_changed(camera, std::nullopt);
  work();
  EXPECT_FALSE(keeper_->snapshot()->reference);
  EXPECT_GT(keeper_->snapshot()->sensor_epoch, epoch);
  const std::string why = keeper_->snapshot()->obstacle.reason;
  EXPECT_NE(why.find("camera.roi.width was 656, and is 640"), std::string::npos) << why;
  EXPECT_GT(keeper_->snapshot()->obstacle.t_since_ns, 0);
  EXPECT_EQ(events_of("reference"), std::vector<std::string>{why + "; take a new reference"});
  keeper_->camera_changed(config_.camera.settings, std::nullopt);
  work();
  EXPECT_TRUE(keeper_->snapshot()->reference);
  EXPECT_EQ(keeper_->snapshot()->obstacle.reason, "");
  ASSERT_TRUE(edit(forget_reference()));
  EXPECT_EQ(keeper_->snapshot()->obstacle.reason, "") << "it was wanted";
}

}  // namespace
}  // namespace ovws
