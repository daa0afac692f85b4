/// The camera actor's handling of gains and of unusable frames, with a fake camera that the test
/// controls. This program's own open_camera replaces the driver table's.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <future>
#include <optional>
#include <thread>

#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/devices/driver_table.hpp"
#include "tests/support/time.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

/// State shared by the test and the fake camera that the actor owns.
struct Device {
  std::atomic<bool> alive{true};
  std::atomic<bool> refuses_gains{false};
  std::atomic<bool> rounds_gains{false};  ///< to whole dB
  std::optional<CameraSettings> asked;    ///< of the last call
  std::atomic<bool> loses_power{false};   ///< at the next set
  std::atomic<bool> absent{false};        ///< cannot be opened
  std::atomic<GrabStatus> sends{GrabStatus::incomplete};
  std::atomic<int> grabs{0};
};
Device* device = nullptr;

class RefusingCamera final : public Camera {
 public:
  const CameraInfo& info() const override { return info_; }
  Result<CameraLimits> limits() override {
    CameraLimits limits;
    limits.gain_db = {0.0, 48.0, 0.0};
    limits.exposure_us = {10.0, 1e6, 0.0};
    limits.frame_rate_hz = {0.01, 1000.0, 0.0};
    limits.roi_width = limits.roi_height = {16, 1024, 1};
    limits.sensor_width = limits.sensor_height = 1024;
    limits.pixel_formats = {PixelFormat::mono8};
    return limits;
  }
  Result<CameraSettings> apply(const CameraSettings& wanted) override {
    device->asked = wanted;
    if (device->loses_power.exchange(false)) {
      dead_ = true;
      return fail(Errc::device, "camera.gain_db", "the camera was reset");
    }
    if (device->refuses_gains && wanted.gain_db != settings_.gain_db) {
      return fail(Errc::refused, "camera.gain_db", "the register is locked");
    }
    settings_ = wanted;
    if (device->rounds_gains) settings_.gain_db = std::round(wanted.gain_db);
    return settings_;
  }
  Result<void> start() override { return {}; }
  void stop() override {}
  bool alive() const override { return device->alive && !dead_; }
  int buffer_count() const override { return 1; }
  /// Reports that the camera is alive, without a usable frame.
  GrabStatus grab(GrabbedFrame& /*out*/, std::chrono::microseconds /*timeout*/) override {
    ++device->grabs;
    std::this_thread::sleep_for(2ms);
    return device->sends;
  }
  void release(int /*slot*/) override {}

 private:
  CameraInfo info_;
  CameraSettings settings_;
  std::atomic<bool> dead_{false};
};

class CameraActorTest : public testing::Test {
 protected:
  CameraActorTest() {
    device = &device_;
    config_.settings.gain_db = 3.0;
    config_.settings.frame_rate_hz = 0.05;  // counts as lost after a silent minute
    frame_path_ = std::thread([this] {
      while (!ended_) pipeline_.acquisition().do_work();
    });
    open();
  }
  ~CameraActorTest() override {
    actor_->on_close();
    ended_ = true;
    frame_path_.join();
  }

  void open() {
    actor_.emplace(config_, CameraActorDeps{pipeline_, settings_, counters_, events_,
                                            [this](const CameraSnapshot& now) {
                                              if (on_change_) on_change_(now);
                                            }});
    actor_->do_work();
    EXPECT_TRUE(actor_->snapshot().connected) << actor_->snapshot().fault;
  }
  Result<CameraSnapshot> set(double value,
                             double CameraSettings::*setting = &CameraSettings::gain_db) {
    CameraSet change;
    change.put(setting, value);
    std::optional<Result<CameraSnapshot>> answer;
    actor_->change(change, [&](Result<CameraSnapshot> set) { answer = std::move(set); });
    actor_->do_work();
    return answer.value_or(fail(Errc::internal, "", "no answer"));
  }
  bool restored(double gain_db) {
    bool done = false;
    CameraSet before;
    before.put(&CameraSettings::gain_db, gain_db);
    actor_->restore(before, [&done] { done = true; });
    actor_->do_work();
    return done;
  }
  Result<CameraSnapshot> select(const std::string& id, std::optional<double> gain_db, bool wait) {
    CameraSet change;
    if (gain_db) change.put(&CameraSettings::gain_db, *gain_db);
    std::optional<Result<CameraSnapshot>> answer;
    actor_->select(id, change, wait, [&](Result<CameraSnapshot> now) { answer = std::move(now); });
    actor_->do_work();
    return answer.value_or(fail(Errc::internal, "", "no answer"));
  }
  /// Lets the actor work, with simulated time between its turns.
  void turns_until(const std::function<bool()>& condition) {
    for (int turn = 0; turn < 400 && !condition(); ++turn) {
      test::skip(500ms);
      actor_->do_work();
    }
  }
  /// Takes the queued events whose data has this key.
  std::vector<EventMessage> events_with(const char* key) {
    std::vector<EventMessage> found;
    while (auto message = queue_.take()) {
      auto* const event = std::get_if<EventMessage>(&*message);
      if (event != nullptr && event->data.contains(key)) found.push_back(std::move(*event));
    }
    return found;
  }

  Device device_;
  CameraConfig config_;
  StreamQueue queue_;
  Events events_{queue_};
  Counters counters_;
  LatestValue<ShownHologram> shown_;
  LatestValue<AppliedSettings> settings_;
  Pipeline pipeline_{PipelineConfig{}, {counters_, shown_, settings_}};
  std::function<void(const CameraSnapshot&)> on_change_;
  std::optional<CameraActor> actor_;
  std::atomic<bool> ended_{false};
  std::thread frame_path_;
};

TEST_F(CameraActorTest, GainIsPutBackWithoutAWord) {
  ASSERT_TRUE(set(20.0));
  EXPECT_EQ(actor_->snapshot().settings.gain_db, 20.0);
  EXPECT_TRUE(restored(3.0));
  EXPECT_EQ(actor_->snapshot().settings.gain_db, 3.0);
  EXPECT_TRUE(events_with("gain_db").empty());
}

TEST_F(CameraActorTest, AFrameRateIsExpectedOfUnchangedSettingsWithoutATrigger) {
  EXPECT_EQ(actor_->snapshot().expected_hz(0), std::nullopt) << "the stream began later";
  const std::int64_t begin_ns = monotonic_ns();
  EXPECT_EQ(actor_->snapshot().expected_hz(begin_ns), config_.settings.frame_rate_hz);
  test::skip(1s);
  ASSERT_TRUE(set(20.0));
  EXPECT_EQ(actor_->snapshot().expected_hz(begin_ns), std::nullopt);
  EXPECT_EQ(actor_->snapshot().expected_hz(monotonic_ns()), config_.settings.frame_rate_hz);
  actor_->on_close();
  config_.trigger = "Line0";
  open();
  EXPECT_EQ(actor_->snapshot().expected_hz(monotonic_ns()), std::nullopt);
}

TEST_F(CameraActorTest, GainThatTheCameraRefusesFailsTheJobAndStaysAsItWas) {
  device_.refuses_gains = true;
  const auto refused = set(20.0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().field, "gain_db");
  EXPECT_EQ(refused.error().reason, "the register is locked");
  EXPECT_TRUE(needs_intervention(refused.error()));  // so a sweep does not retry it
  EXPECT_TRUE(actor_->snapshot().connected);
  EXPECT_EQ(actor_->snapshot().settings.gain_db, 3.0);
}

TEST_F(CameraActorTest, GainThatTheCameraRoundsIsKnownAsReadBackAndAsAskedFor) {
  device_.rounds_gains = true;
  EXPECT_TRUE(set(4.3));
  EXPECT_EQ(actor_->snapshot().settings.gain_db, 4.0);
  EXPECT_EQ(actor_->snapshot().asked.gain_db, 4.3);
  ASSERT_TRUE(set(20.2));
  EXPECT_TRUE(restored(4.3));
  EXPECT_EQ(actor_->snapshot().settings.gain_db, 4.0);
  EXPECT_EQ(actor_->snapshot().asked.gain_db, 4.3);
  device_.refuses_gains = true;
  EXPECT_FALSE(set(7.1));
  EXPECT_EQ(actor_->snapshot().asked.gain_db, 4.3);
}

TEST_F(CameraActorTest, GainBroughtIntoRangeIsAskedForAsThat) {
  CameraSet change;
  change.put(&CameraSettings::gain_db, 60.0);
  change.set_clamp(true);
  actor_->change(change, [](const Result<CameraSnapshot>& set) { EXPECT_TRUE(set); });
  actor_->do_work();
  EXPECT_EQ(actor_->snapshot().asked.gain_db, 48.0);
}

TEST_F(CameraActorTest, GainThatCannotBePutBackIsAnEventAndIsAskedForNextTime) {
  ASSERT_TRUE(set(20.0));
  device_.refuses_gains = true;
  EXPECT_TRUE(restored(3.0));
  const auto events = events_with("gain_db");
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].kind, "camera");
  EXPECT_EQ(events[0].severity, Severity::warning);
  EXPECT_EQ(events[0].data["gain_db"], 3.0);
  EXPECT_EQ(events[0].text,
            "camera: the settings {\"gain_db\":3.0} could not be restored: the register is "
            "locked; set them with camera.set");
  EXPECT_EQ(actor_->snapshot().settings.gain_db, 3.0);
  device_.refuses_gains = false;
  EXPECT_TRUE(set(500.0, &CameraSettings::exposure_us));
  ASSERT_TRUE(device_.asked);
  EXPECT_EQ(device_.asked->gain_db, 3.0);
  EXPECT_EQ(device_.asked->exposure_us, 500.0);
}

TEST_F(CameraActorTest, GainOfALostCameraIsAskedForWhenThereIsOne) {
  ASSERT_TRUE(set(20.0));
  device_.alive = false;
  actor_->do_work();
  ASSERT_FALSE(actor_->snapshot().connected);
  EXPECT_TRUE(restored(3.0));
  EXPECT_TRUE(events_with("gain_db").empty());
  EXPECT_EQ(actor_->snapshot().settings.gain_db, 3.0);
  device_.alive = true;
  turns_until([this] { return actor_->snapshot().connected; });
  ASSERT_TRUE(actor_->snapshot().connected);
  EXPECT_EQ(device_.asked->gain_db, 3.0);
}

TEST_F(CameraActorTest, NothingIsGrabbedFromACameraThatWasReportedAsLost) {
  std::optional<int> then, later;
  on_change_ = [&](const CameraSnapshot& now) {
    if (now.connected || then) return;
    then = device_.grabs.load();
    std::this_thread::sleep_for(50ms);
    later = device_.grabs.load();
  };
  device_.alive = false;
  actor_->do_work();
  on_change_ = nullptr;
  ASSERT_TRUE(then);
  EXPECT_EQ(then, later);
}

TEST_F(CameraActorTest, TheDaemonsStateIsUpdatedBeforeAnEventOrASnapshotReportsTheCamera) {
  std::atomic<bool> updated{false}, seen_updated{false};
  std::optional<std::size_t> events_before;
  std::thread reader;
  device_.alive = false;
  actor_->do_work();
  const auto events = [this] {
    std::size_t count = 0;
    while (const auto message = queue_.take())
      count += std::holds_alternative<EventMessage>(*message);
    return count;
  };
  (void)events();
  on_change_ = [&](const CameraSnapshot& now) {
    if (!now.connected || events_before) return;
    events_before = events();
    std::promise<void> reads;
    reader = std::thread([&] {
      reads.set_value();
      while (!actor_->snapshot().connected) {
      }
      seen_updated = updated.load();
    });
    reads.get_future().wait();
    std::this_thread::sleep_for(50ms);
    updated = true;
  };
  device_.alive = true;
  turns_until([&] { return events_before.has_value(); });
  on_change_ = nullptr;
  ASSERT_TRUE(events_before);
  reader.join();
  EXPECT_EQ(*events_before, 0U);
  EXPECT_EQ(events(), 1U) << "the camera is connected";
  EXPECT_TRUE(seen_updated);
}

TEST_F(CameraActorTest, CameraThatLostPowerDuringASetIsOpenedAgainWithAllThatWasAsked) {
  EXPECT_TRUE(set(300.0, &CameraSettings::exposure_us));
  device_.loses_power = true;
  const auto now = set(5.0);
  ASSERT_TRUE(now) << now.error().reason;
  EXPECT_TRUE(now->connected);
  EXPECT_EQ(counters_.get(Counter::camera_reconnects), 1U);
  EXPECT_EQ(device_.asked->gain_db, 5.0);
  EXPECT_EQ(device_.asked->exposure_us, 300.0);
  EXPECT_EQ(actor_->snapshot().settings, *device_.asked);
  EXPECT_EQ(actor_->snapshot().asked.gain_db, 5.0);
}

TEST_F(CameraActorTest, CameraThatLostPowerAndIsNotBackRefusesASetAndKeepsTheSettingsOfBefore) {
  device_.loses_power = true;
  device_.absent = true;
  const auto refused = set(20.0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().reason, "no camera is connected: there is no camera");
  EXPECT_FALSE(actor_->snapshot().connected);
  settings_.update();  // done by the frame path when a frame comes
  EXPECT_EQ(settings_.value().t_write_end_mono_ns, ShownHologram::kNever) << "its gain is unknown";
  device_.absent = false;
  turns_until([this] { return actor_->snapshot().connected; });
  ASSERT_TRUE(actor_->snapshot().connected);
  EXPECT_EQ(device_.asked->gain_db, 3.0);
}

TEST_F(CameraActorTest, AnotherCameraIsSelectedWithTheGivenSettings) {
  device_.rounds_gains = true;
  ASSERT_TRUE(set(4.3));
  const auto other = select("other", std::nullopt, true);
  ASSERT_TRUE(other) << other.error().reason;
  EXPECT_EQ(other->id, "other");
  EXPECT_EQ(device_.asked->gain_db, 4.3) << "not as the former camera rounded it";
  const auto third = select("third", 7.2, true);
  ASSERT_TRUE(third) << third.error().reason;
  EXPECT_EQ(third->settings.gain_db, 7.0);
  EXPECT_EQ(third->asked.gain_db, 7.2);
}

TEST_F(CameraActorTest, AnAbsentCameraIsOnlySelectedIfItIsWaitedFor) {
  device_.absent = true;
  EXPECT_FALSE(select("absent", 7.0, false));
  EXPECT_NE(actor_->snapshot().id, "absent");
  EXPECT_EQ(actor_->snapshot().asked.gain_db, 3.0);
  const auto waits = select("absent", 7.0, true);
  ASSERT_TRUE(waits) << waits.error().reason;
  EXPECT_FALSE(waits->connected);
  EXPECT_EQ(waits->id, "absent");
  EXPECT_EQ(waits->settings.gain_db, 7.0) << "for its next connection";
}

TEST_F(CameraActorTest, SaysWhyNoFrameCanBeUsed) {
  const std::pair<GrabStatus, const char*> causes[]{
      {GrabStatus::incomplete, "frames_incomplete"},
      {GrabStatus::duplicate, "frames_duplicated"},
      {GrabStatus::out_of_order, "frames_out_of_order"}};
  std::vector<std::string> texts;
  for (const auto& [sends, counter] : causes) {
    SCOPED_TRACE(counter);
    device_.sends = sends;
    // Reconnects the camera, so that earlier reports no longer count.
    device_.alive = false;
    actor_->do_work();
    device_.alive = true;
    std::vector<EventMessage> events;
    turns_until([&] { return !(events = events_with("counter")).empty(); });
    ASSERT_EQ(events.size(), 1U);
    EXPECT_EQ(events[0].data["counter"], counter);
    EXPECT_EQ(events[0].kind, "camera");
    EXPECT_EQ(events[0].severity, Severity::error);
    texts.push_back(events[0].text);
    for (int turn = 0; turn < 10; ++turn) actor_->do_work();
    EXPECT_TRUE(events_with("counter").empty()) << "reported once";
  }
  EXPECT_NE(texts[0].find("incomplete"), std::string::npos);
  EXPECT_EQ(texts[1].find("incomplete"), std::string::npos);
  EXPECT_EQ(texts[2].find("incomplete"), std::string::npos);
}

TEST_F(CameraActorTest, CameraThatStopsWithinAFrameSendsNoFrames) {
  const auto incomplete = [this] { return counters_.get(Counter::frames_incomplete); };
  for (int turn = 0; turn < 2000 && incomplete() < 10; ++turn) std::this_thread::sleep_for(2ms);
  ASSERT_GE(incomplete(), 10U);
  device_.sends = GrabStatus::timeout;
  turns_until([this] { return !actor_->snapshot().connected; });
  EXPECT_NE(actor_->snapshot().fault.find("sends no frames"), std::string::npos);
  EXPECT_TRUE(events_with("counter").empty());
}

}  // namespace

Result<std::unique_ptr<Camera>> open_camera(const CameraConfig& /*config*/) {
  if (device->absent) return fail(Errc::unavailable, "camera.id", "there is no camera");
  return std::make_unique<RefusingCamera>();
}

}  // namespace ovws
