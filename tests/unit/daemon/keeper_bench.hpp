/// SensorKeeper on the small bench, in the thread of the test, with a fake display.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/ovwsd/actor/stream_queue.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "tests/support/own_folder.hpp"
#include "tests/unit/daemon/small_bench.hpp"

namespace ovws::test {

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
inline Screen* screen = nullptr;

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

/// The small bench, seen by a camera that all of its spots reach.
inline Config seen_bench() {
  Config config = small_bench();
  config.slm.settle_ms = 0.0;
  config.sensor.spacing = 0.47;
  config.camera.settings.roi = {0, 0, 656, 816};
  return config;
}

inline const CameraInfo kFirst{"Ovws", "Twin", "1", ""}, kSecond{"Ovws", "Twin", "2", ""};
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
        SensorKeeper::make(config_, {parts_->pipeline, parts_->slm, parts_->events, parts_->library,
                                     parts_->leases, [](const MeasurementPlan&, SensorView) {}});
    ASSERT_TRUE(made) << made.error().reason;
    keeper_ = std::move(*made);
    parts_->leases.set(&Conditions::started, true);
  }
  void end() {
    keeper_.reset();
    running_ = false;
    if (display_.joinable()) display_.join();
    parts_.reset();
  }

  /// Makes a change, carries out all queued work, and returns the keeper's answer.
  Result<SensorView> edit(SensorChange change) {
    std::optional<Result<SensorView>> answer;
    keeper_->edit(std::move(change), [&](Result<SensorView> now) { answer = std::move(now); });
    work();
    EXPECT_TRUE(answer);
    return answer ? *answer : fail(Errc::internal, "", "no answer");
  }
  void work() {
    bool idle = false;
    keeper_->after_changes([] {});
    while (!idle) {
      idle = !keeper_->do_work();
    }
  }
  /// The texts of the queued events that are wanted; all queued messages are taken.
  std::vector<std::string> events_where(const std::function<bool(const EventMessage&)>& wanted) {
    std::vector<std::string> texts;
    while (const auto message = parts_->queue.take()) {
      const auto* event = std::get_if<EventMessage>(&*message);
      if (event != nullptr && wanted(*event)) texts.push_back(event->text);
    }
    return texts;
  }
  std::vector<std::string> events_of(const std::string& kind) {
    return events_where([&](const EventMessage& event) { return event.kind == kind; });
  }
  std::vector<std::string> errors() {
    return events_where(
        [](const EventMessage& event) { return event.severity == Severity::error; });
  }
  /// Lets `holder` have the sensor from now on.
  void turn_to(Holder holder) {
    keeper_->take_turn(holder, nullptr);
    work();
  }

  /// Makes a registration of this scale, px per cycle, active, as a job does.
  void use_map(double scale) {
    Registration map;
    map.px_per_cycle = {scale, 0.0, 0.0, scale};
    map.base_px = {130.0, 120.0};
    map.t_taken_ns = 5;
    turn_to(Holder::job);
    ASSERT_TRUE(edit(use_registration(map)));
    turn_to(Holder::nobody);
  }

  struct Parts {
    explicit Parts(const Config& config)
        : slm(config.slm, {shown, counters, events,
                           [this](const SlmSnapshot& now) {
                             if (now.healthy) opened_with_id = now.hologram_id;
                           }}),
          pipeline(config.pipeline, {counters, shown, settings}),
          library(config.state, events) {}
    Counters counters;
    std::atomic<std::uint64_t> opened_with_id{kNotOpened};  ///< hologram of the open display
    StreamQueue queue;
    Events events{queue};
    Leases leases{events, false};
    LatestValue<ShownHologram> shown;
    LatestValue<AppliedSettings> settings;
    SlmLoop slm;
    Pipeline pipeline;
    Library library;
  };
  Screen screen_;
  const std::string folder_ = own_folder("sensor_keeper");
  Config config_ = seen_bench();
  std::atomic<bool> running_{true};
  std::unique_ptr<Parts> parts_;
  std::thread display_;
  std::unique_ptr<SensorKeeper> keeper_;
};

}  // namespace ovws::test
