/// SensorKeeper: which holograms it shows, and who may change the sensor, with a fake display. This
/// program's own open_display replaces the driver table's.
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/actor/stream_queue.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <thread>

#include "daemon/ovwsd/devices/driver_table.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/support/time.hpp"
#include "tests/unit/daemon/small_bench.hpp"

namespace ovws {
namespace {

/// State shared by the test and the fake display that the SlmLoop owns.
struct Screen {
  std::atomic<bool> there{true};
  std::mutex mutex;
  Image<std::uint8_t> shown;

  Image<std::uint8_t> picture() {
    const std::lock_guard lock(mutex);
    return shown;
  }
};
Screen* screen = nullptr;

class PlayedDisplay final : public Display {
 public:
  explicit PlayedDisplay(const SlmConfig& config)
      : info_{config.display, config.geometry.width_px, config.geometry.height_px, 60.0, "test"} {}
  const DisplayInfo& info() const override { return info_; }
  Result<std::int64_t> present(const Image<std::uint8_t>& grey) override {
    if (!screen->there) return fail(Errc::unavailable, "slm", "it was pulled out");
    const std::lock_guard lock(screen->mutex);
    screen->shown = grey;
    return std::int64_t{1};
  }
  Result<Image<std::uint32_t>> read_back() override { return fail(Errc::unavailable, "", "no"); }
  Result<void> check() override {
    if (!screen->there) return fail(Errc::unavailable, "slm", "it was pulled out");
    return {};
  }

 private:
  DisplayInfo info_;
};

}  // namespace

Result<std::unique_ptr<Display>> open_display(const SlmConfig& config) {
  if (!screen->there) return fail(Errc::unavailable, "slm", "it was pulled out");
  return std::make_unique<PlayedDisplay>(config);
}
Result<std::unique_ptr<Camera>> open_camera(const CameraConfig&) {
  return fail(Errc::unavailable, "camera", "there is none");
}

namespace {

/// The small bench, seen by a camera that all of its spots reach.
Config seen_bench() {
  Config config = test::small_bench();
  config.slm.settle_ms = 0.0;
  config.sensor.spacing = 0.47;
  config.camera.settings.roi = {0, 0, 656, 816};
  return config;
}

const CameraInfo kFirst{"Ovws", "Twin", "1", ""}, kSecond{"Ovws", "Twin", "2", ""};
constexpr std::uint64_t kNotOpened = ~std::uint64_t{0};

class Keeper : public testing::Test {
 protected:
  Keeper() {
    screen = &screen_;
    config_.state.directory = folder_;
    start();
  }
  ~Keeper() override {
    end();
    screen = nullptr;
    std::filesystem::remove_all(folder_);
  }

  void start() {
    running_ = true;
    parts_ = std::make_unique<Parts>(config_);
    display_ = std::thread([this] {
      while (running_) parts_->slm.do_work();
      parts_->slm.close();
    });
    auto made =
        SensorKeeper::make(config_, {parts_->pipeline, parts_->slm, parts_->events, parts_->store,
                                     [](const MeasurementPlan&, SensorView) {},
                                     [this](Hold::By by) { holder_ = by; }});
    ASSERT_TRUE(made) << made.error().reason;
    keeper_ = std::move(*made);
  }
  void end() {
    keeper_.reset();
    running_ = false;
    if (display_.joinable()) display_.join();
    parts_.reset();
  }

  /// Makes a change, carries out all queued work, and returns the keeper's answer.
  Result<SensorView> edit(Hold as, SensorChange change) {
    std::optional<Result<SensorView>> answer;
    keeper_->edit(as, std::move(change), [&](Result<SensorView> now) { answer = std::move(now); });
    work();
    EXPECT_TRUE(answer);
    return answer ? *answer : fail(Errc::internal, "", "no answer");
  }
  Result<SensorView> edit(SensorChange change) { return edit(Hold::unheld(), std::move(change)); }
  void work() {
    bool idle = false;
    keeper_->after_changes([] {});
    while (!idle) {
      idle = !keeper_->do_work();
    }
  }
  /// The texts of the queued events of this kind; all queued messages are taken.
  std::vector<std::string> events_of(const std::string& kind) {
    std::vector<std::string> texts;
    while (const auto message = parts_->queue.take()) {
      const auto* event = std::get_if<EventMessage>(&*message);
      if (event != nullptr && event->kind == kind) texts.push_back(event->text);
    }
    return texts;
  }
  void release(Hold by) {
    keeper_->release(by, [] {});
    work();
  }

  /// Makes a registration of this scale, px per cycle, active, as a job does.
  void use_map(double scale) {
    Registration map;
    map.px_per_cycle = {scale, 0.0, 0.0, scale};
    map.base_px = {130.0, 120.0};
    map.t_taken_ns = 5;
    const Hold job = Hold::of_job(1);
    work();
    keeper_->hold(job);
    ASSERT_TRUE(edit(job, use_registration(map)));
    release(job);
  }
  /// The texts of the queued events of severity `error`.
  std::vector<std::string> errors() {
    std::vector<std::string> found;
    while (const auto message = parts_->queue.take()) {
      const auto* const event = std::get_if<EventMessage>(&*message);
      if (event != nullptr && event->severity == Severity::error) found.push_back(event->text);
    }
    return found;
  }

  struct Parts {
    explicit Parts(const Config& config)
        : slm(config.slm, {shown, counters, events,
                           [this](const SlmSnapshot& now) {
                             if (now.healthy) opened_with_id = now.hologram_id;
                           }}),
          pipeline(config.pipeline, {counters, shown, settings}),
          store(config.state, events) {}
    Counters counters;
    std::atomic<std::uint64_t> opened_with_id{kNotOpened};  ///< hologram of the open display
    StreamQueue queue;
    Events events{queue};
    LatestValue<ShownHologram> shown;
    LatestValue<AppliedSettings> settings;
    SlmLoop slm;
    Pipeline pipeline;
    DaemonStore store;
  };
  Screen screen_;
  const std::string folder_ = own_folder("sensor_keeper");
  Config config_ = seen_bench();
  std::atomic<bool> running_{true};
  std::unique_ptr<Parts> parts_;
  std::thread display_;
  std::unique_ptr<SensorKeeper> keeper_;
  Hold::By holder_ = Hold::By::nobody;  ///< as on_hold said
};

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

TEST_F(Keeper, IsChangedByWhoHoldsItOnly) {
  const Hold job = Hold::of_job(7);
  ASSERT_TRUE(keeper_->may_hold());
  ASSERT_TRUE(edit(set_aberration({{3, 0.1}})));
  keeper_->hold(job);
  EXPECT_FALSE(keeper_->may_hold());
  const Image<std::uint8_t> user = screen_.picture();
  for (const Hold& other : {Hold::unheld(), Hold::of_loop(), Hold::of_job(8)}) {
    const auto refused = edit(other, set_aberration({}));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::refused);
  }
  const auto shown = edit(job, show_request({{{5, 0.3}}, nullptr}));
  ASSERT_TRUE(shown);
  EXPECT_EQ((*shown)->aberration, (std::vector<Mode>{{5, 0.3}}));
  release(Hold::of_job(8));
  EXPECT_FALSE(keeper_->may_hold()) << "it is another job's";
  release(job);
  EXPECT_TRUE(keeper_->may_hold());
  EXPECT_EQ(keeper_->snapshot()->aberration, (std::vector<Mode>{{3, 0.1}}));
  EXPECT_EQ(screen_.picture().pixels, user.pixels);
  EXPECT_FALSE(edit(job, show_request({{{5, 0.3}}, nullptr}))) << "it has ended";
}

TEST_F(Keeper, AJobThatEndsWithoutADisplayIsTakenBackAllTheSame) {
  const Hold job = Hold::of_job(1);
  keeper_->hold(job);
  ASSERT_TRUE(edit(job, show_request({{{5, 0.3}}, nullptr})));
  screen_.there = false;
  release(job);
  EXPECT_TRUE(keeper_->may_hold());
  EXPECT_TRUE(keeper_->snapshot()->aberration.empty());
}

TEST_F(Keeper, LetsTheAberrationChangeWhileTheLoopIsClosed) {
  keeper_->hold(Hold::of_loop());
  EXPECT_TRUE(edit(Hold::of_loop(), set_aberration({{3, 0.1}})));
  EXPECT_TRUE(edit(Hold::of_loop(), set_correction({{3, 0.1}})));
  EXPECT_FALSE(edit(set_correction({})));
  EXPECT_FALSE(edit(show_pattern(HologramKind::flat)));
  release(Hold::of_loop());
  EXPECT_TRUE(edit(set_correction({})));
}

TEST_F(Keeper, IsReleasedByTheLastStepOfAChangeAlsoIfThatThrowsOrIsDropped) {
  for (const bool throws : {true, false}) {
    Mailbox other;
    std::string outcome;
    keeper_->hold(Hold::of_lattice());
    auto turn = keeper_->release_with_last<std::string>(
        Hold::of_lattice(), "did not end", [&](const std::string& last) { outcome = last; });
    other.post([turn] { throw std::runtime_error(*turn); });
    turn.reset();
    work();
    EXPECT_EQ(holder_, Hold::By::lattice) << "a step waits";
    if (throws) {
      EXPECT_THROW(other.run_one(std::chrono::milliseconds(0)), std::runtime_error);
    }
    other.close();
    work();
    EXPECT_EQ(holder_, Hold::By::nobody);
    EXPECT_EQ(outcome, "did not end");
  }
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
  EXPECT_EQ((*referenced)->reference->sha256.size(), 64U);
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
  EXPECT_NE(why.find("it was taken with another region of the camera"), std::string::npos) << why;
  EXPECT_GT(keeper_->snapshot()->obstacle.t_since_ns, 0);
  EXPECT_EQ(events_of("reference"), std::vector<std::string>{why + "; take a new reference"});
  keeper_->camera_changed(config_.camera.settings, std::nullopt);
  work();
  EXPECT_TRUE(keeper_->snapshot()->reference);
  EXPECT_EQ(keeper_->snapshot()->obstacle.reason, "");
  ASSERT_TRUE(edit(forget_reference()));
  EXPECT_EQ(keeper_->snapshot()->obstacle.reason, "") << "it was wanted";
}

TEST_F(Keeper, WhatWasMeasuredOfAnotherImageIsRefused) {
  const std::uint64_t epoch = keeper_->snapshot()->sensor_epoch;
  const Hold job = Hold::of_job(1);
  keeper_->hold(job);
  CameraSettings camera = config_.camera.settings;
  camera.roi = {16, 0, 640, 816};
  keeper_->camera_changed(camera, std::nullopt);
  work();
  const auto spots = std::make_shared<std::vector<ReferenceSpots>>();
  const auto refused = edit(job, use_reference(epoch, {}, spots));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "camera");
  EXPECT_FALSE(keeper_->snapshot()->reference);
}

TEST_F(Keeper, ARegistrationOfAnotherCameraIsNotUsed) {
  keeper_->camera_changed(config_.camera.settings, kFirst);
  use_map(900.0);
  ASSERT_TRUE(keeper_->snapshot()->registration);
  keeper_->camera_changed(config_.camera.settings, kSecond);
  work();
  EXPECT_FALSE(keeper_->snapshot()->registration);
}

/// The registration says that spots are large enough for the tracker, the configuration that they
/// are not: without the registration no plan can be built.
TEST_F(Keeper, ACameraForWhichNoPlanCanBeBuiltIsReportedAndNothingMeasuredWithAnotherIsUsed) {
  keeper_->camera_changed(config_.camera.settings, kFirst);
  use_map(900.0);
  end();
  config_.optics.focal_length_mm = 10.0;
  start();
  keeper_->camera_changed(config_.camera.settings, kFirst);
  work();
  ASSERT_TRUE(keeper_->snapshot()->registration);
  const SensorView before = keeper_->snapshot();
  (void)errors();
  CameraSettings other_region = config_.camera.settings;
  other_region.roi = {16, 0, 640, 816};
  keeper_->camera_changed(other_region, kSecond);
  work();
  const SensorView now = keeper_->snapshot();
  EXPECT_FALSE(now->registration);
  EXPECT_FALSE(now->optics.registered);
  EXPECT_EQ(now->plan_id, 0U);
  EXPECT_GT(now->sensor_epoch, before->sensor_epoch) << "frames of the previous plan do not count";
  const auto found = errors();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].starts_with("the camera's image cannot be measured: lambda/d")) << found[0];
  EXPECT_EQ(now->obstacle.reason, found[0]);
  EXPECT_NE(now->obstacle.action.find("camera.set"), std::string::npos) << now->obstacle.action;
  EXPECT_GT(now->obstacle.t_since_ns, 0);
}

/// Without the registration the spots are too small for a colour camera only.
TEST_F(Keeper, AnotherCameraIsJudgedByItsOwnImageAlone) {
  keeper_->camera_changed(config_.camera.settings, kFirst);
  use_map(900.0);
  end();
  config_.optics.focal_length_mm = 16.0;  // lambda/d of 4.8 px
  start();
  CameraSettings colour = config_.camera.settings;
  colour.pixel_format = PixelFormat::bayer_rg8;
  keeper_->camera_changed(colour, kFirst);
  work();
  ASSERT_TRUE(keeper_->snapshot()->registration);
  ASSERT_GT(keeper_->snapshot()->plan_id, 0U);
  (void)errors();
  CameraSettings mono = config_.camera.settings;
  mono.roi = {16, 0, 640, 816};
  keeper_->camera_changed(mono, kSecond);
  work();
  EXPECT_FALSE(keeper_->snapshot()->registration);
  EXPECT_GT(keeper_->snapshot()->plan_id, 0U);
  EXPECT_EQ(errors(), std::vector<std::string>{});
}

TEST_F(Keeper, WhatAJobHadChangedIsRestoredEvenIfTheCamerasImageCannotBeMeasuredAnyMore) {
  use_map(160.0);  // lambda/d of 5 px: too small for a colour camera
  const Image<std::uint8_t> user = screen_.picture();
  const Hold job = Hold::of_job(2);
  keeper_->hold(job);
  const Painter white = [](const HologramRenderer&, Image<std::uint8_t>& grey) {
    grey = Image<std::uint8_t>(160, 96);
    std::fill(grey.pixels.begin(), grey.pixels.end(), std::uint8_t(255));
  };
  ASSERT_TRUE(edit(job, show_request({{}, white})));
  ASSERT_NE(screen_.picture().pixels, user.pixels);
  CameraSettings colour = config_.camera.settings;
  colour.pixel_format = PixelFormat::bayer_rg8;
  keeper_->camera_changed(colour, std::nullopt);
  work();
  EXPECT_EQ(errors().size(), 1U);
  const std::int64_t t_since_ns = keeper_->snapshot()->obstacle.t_since_ns;
  release(job);
  EXPECT_EQ(errors().size(), 1U);
  EXPECT_EQ(keeper_->snapshot()->plan_id, 0U);
  EXPECT_EQ(keeper_->snapshot()->obstacle.t_since_ns, t_since_ns) << "it goes on";
  EXPECT_TRUE(keeper_->may_hold());
  EXPECT_EQ(screen_.picture().pixels, user.pixels);
  keeper_->camera_changed(config_.camera.settings, std::nullopt);
  work();
  EXPECT_GT(keeper_->snapshot()->plan_id, 0U) << "as soon as a plan can be built";
  EXPECT_EQ(keeper_->snapshot()->obstacle.reason, "");
}

TEST_F(Keeper, AStartWithAnotherLensThanTheRegistrationsSaysSo) {
  Registration map;
  map.px_per_cycle = {900.0, 0.0, 0.0, 900.0};
  map.base_px = {130.0, 120.0};
  map.t_taken_ns = 5;
  keeper_->hold(Hold::of_job(1));
  ASSERT_TRUE(edit(Hold::of_job(1), use_registration(map)));
  const auto warned = [this] {
    bool found = false;
    while (const auto message = parts_->queue.take()) {
      const auto* event = std::get_if<EventMessage>(&*message);
      found = found || (event != nullptr && event->kind == "registration" &&
                        event->text.find("optics.focal_length_mm was") != std::string::npos &&
                        event->text.find("registration.run") != std::string::npos);
    }
    return found;
  };
  end();
  start();
  EXPECT_FALSE(warned());
  end();
  config_.optics.focal_length_mm *= 1.5;
  start();
  EXPECT_TRUE(keeper_->snapshot()->registration);
  EXPECT_TRUE(warned());
}

}  // namespace
}  // namespace ovws
