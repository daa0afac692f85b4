/// ClosedLoop on the simulated bench: a hidden wavefront is corrected, and the loop opens on
/// request or by itself. The bench's open_display and open_camera replace those of the driver
/// table.
#include "daemon/ovwsd/loop/closed_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "tests/support/simulated_bench.hpp"
#include "tests/support/time.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

constexpr double kPatienceS = 4.0;

class ClosedLoopTest : public testing::Test {
 protected:
  ~ClosedLoopTest() override {
    end_ = true;
    thread_.join();
  }

  void take_reference_frames() {
    const auto taken = bench_.run("reference.take", [](Bench& on) {
      return take_reference(on, {10, false, {}});
    });
    ASSERT_TRUE(taken) << taken.error().reason;
  }
  /// The light's own aberration, which only the simulated optics know.
  void hide(std::vector<Mode> aberration) {
    twin::Truth truth = bench_.optics().truth();
    truth.aberration = std::move(aberration);
    bench_.optics().set_truth(truth);
  }
  void switch_off_the_light() {
    twin::Truth dark = bench_.optics().truth();
    dark.peak_electrons = 1.0;
    bench_.optics().set_truth(dark);
  }
  Result<LoopReport> close(const LoopSettings& settings = {}) {
    auto lease = bench_.leases().take(Request::close_loop);
    if (!lease) return fail(lease.error());
    return answer_of(
        [&](auto reply) { loop_.close(std::move(*lease), settings, std::move(reply)); });
  }
  Result<LoopReport> open(bool keep) {
    return answer_of([&](auto reply) { loop_.open(keep, std::move(reply)); });
  }
  Result<LoopReport> pause(bool paused) {
    return answer_of([&](auto reply) { loop_.pause(paused, std::move(reply)); });
  }
  template <class Request>
  static Result<LoopReport> answer_of(Request request) {
    const auto answer = std::make_shared<std::promise<Result<LoopReport>>>();
    request([answer](Result<LoopReport> now) { answer->set_value(std::move(now)); });
    auto future = answer->get_future();
    if (future.wait_for(60s) == std::future_status::ready) return future.get();
    return fail(Errc::unavailable, "", "no answer within 60 s");
  }
  bool wait_for(const std::function<bool()>& condition) {
    for (int k = 0; k < 60'000 && !condition(); ++k) std::this_thread::sleep_for(1ms);
    return condition();
  }
  /// Lets twice the patience pass, a second at a time, after each of which the loop looks at its
  /// watch.
  void pass_twice_the_patience() {
    for (double passed_s = 0.0; passed_s < 2.0 * kPatienceS; ++passed_s) {
      test::skip(1s);
      const int turns = turns_;
      ASSERT_TRUE(wait_for([&] { return turns_ >= turns + 2; }));  // one of them began after it
    }
  }
  bool opens_by_itself() {
    return wait_for([&] {
      test::skip(50ms);
      return !loop_.report().closed;
    });
  }
  /// Lets half a second pass with each step until the loop has opened by itself.
  void expect_opens(const std::string& reason) {
    auto steps = loop_.report().steps;
    ASSERT_TRUE(wait_for([&] {
      const auto now = loop_.report().steps;
      if (now != std::exchange(steps, now)) test::skip(500ms);
      return !loop_.report().closed;
    }));
    EXPECT_EQ(loop_.report().opened_because.substr(0, reason.size()), reason);
  }
  double correction_of(int j) {
    const SensorView sensor = bench_.sensor();
    double waves = 0.0;
    for (const Mode& mode : sensor->correction) waves += mode.j == j ? mode.waves : 0.0;
    return waves;
  }

  test::SimulatedBench bench_;
  ClosedLoop loop_{{bench_.frames(), bench_.keeper(), bench_.leases(), bench_.slm(),
                    bench_.events(), [this] { return finds_ ? monotonic_ns() : 0; },
                    [this] { return why_invalid_; },
                    [](const std::string&, const nlohmann::json&) {}}};
  std::string why_invalid_;         ///< set it before the loop closes
  std::atomic<bool> finds_{false};  ///< lost spots are found all the time
  std::atomic<int> turns_{0};
  std::atomic<bool> end_{false};

 private:
  std::thread thread_{[this] {
    for (; !end_; ++turns_) loop_.do_work();
    loop_.on_close();
  }};
};

TEST_F(ClosedLoopTest, CorrectsAHiddenWavefrontAndKeepsOrDropsTheCorrectionWhenOpened) {
  take_reference_frames();
  hide({{3, -0.05}, {4, 0.08}});
  ASSERT_TRUE(close());
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 12; }));
  const auto kept = open(true);
  ASSERT_TRUE(kept);
  EXPECT_FALSE(kept->closed);
  EXPECT_EQ(kept->opened_because, LoopReport::kOpenedOnRequest);
  EXPECT_LT(*kept->residual_rms_waves, 0.02);
  EXPECT_FALSE(loop_.is_closed());
  EXPECT_NEAR(correction_of(3), -0.05, 0.01);
  EXPECT_NEAR(correction_of(4), 0.08, 0.01);
  for (const double waves : bench_.mean_waves(10)) EXPECT_NEAR(waves, 0.0, 0.01);
  ASSERT_TRUE(close());
  ASSERT_TRUE(open(false));
  EXPECT_TRUE(bench_.sensor()->correction.empty());
  const auto uncorrected = bench_.mean_waves(10);
  ASSERT_GE(uncorrected.size(), 4U);
  EXPECT_NEAR(uncorrected[3], 0.08, 0.01);
}

TEST_F(ClosedLoopTest, HoldsTheSensorWhileItIsClosed) {
  const auto early = close();
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().field, "reference");
  take_reference_frames();
  ASSERT_TRUE(close());
  EXPECT_EQ(close().error().code, Errc::refused);
  EXPECT_EQ(bench_.edit(set_correction({{4, 0.1}})).error().code, Errc::refused);
  ASSERT_TRUE(open(true));
  EXPECT_TRUE(bench_.edit(set_correction({{4, 0.1}})));
  EXPECT_EQ(close({.limit_waves = 0.09}).error().field, "limit_waves");
  EXPECT_EQ(close({.modes = {4, 60}}).error().field, "modes");
  EXPECT_EQ(close({.modes = {4, 4}}).error().field, "modes");
  EXPECT_EQ(close({.gains = {{4, 0.1}, {4, 0.2}}}).error().field, "gains");
  EXPECT_EQ(close({.modes = {3}, .offsets = {{4, 0.1}}}).error().field, "offsets");
  EXPECT_EQ(close({.law = LawName::predictor}).error().field, "law");
}

TEST_F(ClosedLoopTest, OpensAfterACloseThatWasRequestedBefore) {
  take_reference_frames();
  for (int turn = 0; turn < 20; ++turn) {
    // Every second time the close waits for a change under way.
    auto change = turn % 2 == 0 ? LeasePtr() : bench_.leases().take(Request::set_sensor).value();
    auto lease = bench_.leases().take(Request::close_loop);
    ASSERT_TRUE(lease) << lease.error().reason;
    std::atomic<bool> closed{false};
    loop_.close(std::move(*lease), {}, [&](const Result<LoopReport>& now) { closed = bool(now); });
    std::promise<Result<LoopReport>> answer;
    loop_.open(false, [&answer](const Result<LoopReport>& now) { answer.set_value(now); });
    change.reset();
    const auto opened = answer.get_future().get();
    ASSERT_TRUE(opened) << opened.error().reason;
    EXPECT_TRUE(closed);
    EXPECT_FALSE(loop_.is_closed());
  }
}

TEST_F(ClosedLoopTest, HoldsItsCorrectionWhileItIsPaused) {
  EXPECT_EQ(pause(true).error().code, Errc::refused) << "the loop is open";
  take_reference_frames();
  ASSERT_TRUE(close());
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 3; }));
  const auto paused = pause(true);
  ASSERT_TRUE(paused);
  EXPECT_TRUE(paused->closed);
  EXPECT_TRUE(paused->paused);
  EXPECT_TRUE(loop_.is_paused());
  hide({{4, 0.08}});
  std::this_thread::sleep_for(500ms);
  EXPECT_EQ(loop_.report().steps, paused->steps);
  EXPECT_NEAR(correction_of(4), 0.0, 0.01);
  ASSERT_TRUE(pause(false));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= paused->steps + 12; }));
  EXPECT_NEAR(correction_of(4), 0.08, 0.01);
  ASSERT_TRUE(pause(true));
  ASSERT_TRUE(open(true));
  EXPECT_FALSE(loop_.is_paused());
}

/// What the loop corrects counts as disturbance, frame by frame.
TEST_F(ClosedLoopTest, IsWatchedForItsDisturbance) {
  take_reference_frames();
  hide({{4, 0.08}});
  ASSERT_TRUE(close({.gain = 0.1}));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 2; }));  // frames without it are gone
  DisturbanceSeries series;
  const auto watched = bench_.run(
      "loop.identify",
      [&](Bench& on) -> Result<nlohmann::json> {
        auto found = watch_disturbance(on, 3.0, 0.001);
        if (!found) found = watch_disturbance(on, 30.0, 0.001);  // a busy machine measures few
        if (!found) return fail(found.error());
        series = std::move(*found);
        return nlohmann::json();
      },
      Request::watch);
  ASSERT_TRUE(watched) << watched.error().reason;
  ASSERT_GE(series.modes_j.size(), 4U);
  EXPECT_EQ(series.modes_j[3], 4);
  const auto& waves = series.waves.modes_waves[3];
  ASSERT_EQ(waves.size(), series.waves.times_s.size());
  for (const double one : waves) EXPECT_NEAR(one, 0.08, 0.01);
  EXPECT_TRUE(std::ranges::is_sorted(series.waves.times_s, std::less_equal()));
  EXPECT_GE(series.frames_per_sample, 1.0);
}

TEST_F(ClosedLoopTest, HoldsAChosenResidual) {
  take_reference_frames();
  ASSERT_TRUE(close({.offsets = {{4, 0.05}}}));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 12; }));
  EXPECT_LT(*loop_.report().residual_rms_waves, 0.02);
  ASSERT_TRUE(open(true));
  EXPECT_NEAR(correction_of(4), -0.05, 0.01);
}

/// Mode 4 is measured and not corrected, so that its residual stays as large as it becomes.
TEST_F(ClosedLoopTest, OpensByItselfWhenTheResidualGrowsAndKeepsTheCorrection) {
  take_reference_frames();
  hide({{3, -0.05}});
  ASSERT_TRUE(close());
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 12; }));
  ASSERT_TRUE(open(true));  // the level of the next time is low from its first step on
  ASSERT_TRUE(close({.gains = {{4, 0.0}}, .patience_s = kPatienceS}));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 15; }));
  hide({{3, -0.05}, {4, 0.2}});
  expect_opens("the residual was 3 times its previous level for 4 s");
  EXPECT_NEAR(correction_of(3), -0.05, 0.02);
  EXPECT_TRUE(bench_.edit(set_correction({}))) << "the sensor is free again";
}

TEST_F(ClosedLoopTest, OpensByItselfWhenNoUsableFrameComes) {
  take_reference_frames();
  ASSERT_TRUE(close({.patience_s = kPatienceS}));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 1; }));
  ASSERT_TRUE(loop_.is_closed());
  switch_off_the_light();
  ASSERT_TRUE(opens_by_itself());
  EXPECT_EQ(loop_.report().opened_because,
            "no usable frame came for 4 s: the camera sends no settled frame; see camera in ovws "
            "status");
}

TEST_F(ClosedLoopTest, SaysWhyFramesWereNotValidWhenItOpens) {
  take_reference_frames();
  why_invalid_ = "3 of 7 spots are found; the light is low";
  ASSERT_TRUE(close({.patience_s = kPatienceS}));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 1; }));
  switch_off_the_light();
  ASSERT_TRUE(opens_by_itself());
  EXPECT_EQ(loop_.report().opened_because, "no usable frame came for 4 s: " + why_invalid_);
}

TEST_F(ClosedLoopTest, StaysClosedAsLongAsLostSpotsAreFound) {
  take_reference_frames();
  ASSERT_TRUE(close({.patience_s = kPatienceS}));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 1; }));
  switch_off_the_light();
  finds_ = true;
  pass_twice_the_patience();
  EXPECT_TRUE(loop_.is_closed()) << loop_.report().opened_because;
  finds_ = false;
  ASSERT_TRUE(opens_by_itself());
}

TEST_F(ClosedLoopTest, HoldsItsCorrectionWhileTheBenchIsNotConnected) {
  take_reference_frames();
  ASSERT_TRUE(close({.patience_s = kPatienceS}));
  ASSERT_TRUE(wait_for([&] { return loop_.report().steps >= 1; }));
  bench_.leases().set(&Conditions::display, false);
  switch_off_the_light();
  pass_twice_the_patience();
  EXPECT_TRUE(loop_.is_closed()) << loop_.report().opened_because;
  bench_.leases().set(&Conditions::display, true);
  ASSERT_TRUE(opens_by_itself());
}

}  // namespace
}  // namespace ovws
