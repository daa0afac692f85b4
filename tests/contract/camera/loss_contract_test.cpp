/// Camera contract: devices that are controlled by others, unplugged, frozen, or left running by a
/// crash.
#include <algorithm>
#include <cstdio>
#include <thread>

#include "tests/contract/camera/camera_contract.hpp"

namespace ovws::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Upper limit of any call on a device that does not answer; measured times are printed. Only the
/// daemon's camera thread blocks for this long.
constexpr double kBoundSeconds = 15.0;

template <class Action>
double timed(const char* what, Action action) {
  const auto begin = monotonic_ns();
  action();
  const double took_s = double(monotonic_ns() - begin) * 1e-9;
  std::printf("    %-40s %6.2f s\n", what, took_s);
  return took_s;
}

/// Of three calls one ends at once: a busy machine may stop this thread during the others.
template <class Action>
void expect_at_once(const char* what, Action action) {
  const auto [least_s, most_s] =
      std::minmax({timed(what, action), timed(what, action), timed(what, action)});
  EXPECT_LT(least_s, 0.5) << what;
  EXPECT_LT(most_s, kBoundSeconds) << what;
}

TEST_P(CameraLossContract, AnAbsentDeviceIsUnavailable) {
  bench_->unplug();
  EXPECT_LT(timed("open, nothing there",
                  [&] {
                    auto camera = bench_->open();
                    ASSERT_FALSE(camera);
                    EXPECT_EQ(camera.error().code, Errc::unavailable) << camera.error().reason;
                    EXPECT_EQ(camera.error().field, "camera.id");
                  }),
            kBoundSeconds);
}

TEST_P(CameraLossContract, ADeviceControlledByAnotherIsUnavailableAndNotDisturbed) {
  auto first = open_streaming();
  ASSERT_TRUE(first);
  EXPECT_LT(timed("open, controlled by another",
                  [&] {
                    auto second = bench_->open();
                    ASSERT_FALSE(second);
                    EXPECT_EQ(second.error().code, Errc::unavailable) << second.error().reason;
                    EXPECT_EQ(second.error().field, "camera.id");
                  }),
            kBoundSeconds);
  GrabbedFrame frame;
  while (first->grab(frame, milliseconds(0)) == GrabStatus::frame) first->release(frame.slot);
  EXPECT_TRUE(first->alive());
  expect_frames(*first, 10);
  EXPECT_TRUE(first->apply(bench_->settings()));
}

TEST_P(CameraLossContract, AfterUnpluggingCallsFailInTimeAndANewObjectWorks) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  expect_frames(*camera, 10);
  bench_->unplug();

  GrabbedFrame frame;
  GrabStatus status = GrabStatus::frame;
  for (int i = 0; i < 100 && status != GrabStatus::timeout; ++i) {
    status = camera->grab(frame, milliseconds(200));
    if (status == GrabStatus::frame) camera->release(frame.slot);
  }
  EXPECT_EQ(status, GrabStatus::timeout);

  CameraSettings wanted = bench_->settings();
  wanted.gain_db += 1.0;
  Result<CameraSettings> applied;
  EXPECT_LT(timed("apply on a dead device", [&] { applied = camera->apply(wanted); }),
            kBoundSeconds);
  ASSERT_FALSE(applied);
  EXPECT_EQ(applied.error().code, Errc::device) << applied.error().reason;
  EXPECT_FALSE(camera->alive());
  expect_at_once("apply once it is known", [&] { applied = camera->apply(wanted); });
  EXPECT_FALSE(applied);
  expect_at_once("limits once it is known", [&] { EXPECT_FALSE(camera->limits()); });
  EXPECT_LT(timed("stop once it is known", [&] { camera->stop(); }), kBoundSeconds);
  expect_at_once("start once it is known", [&] { EXPECT_FALSE(camera->start()); });
  EXPECT_LT(timed("destructor", [&] { camera.reset(); }), kBoundSeconds);

  bench_->plug_in();
  camera = reopen(seconds(10));
  ASSERT_TRUE(camera);
  ASSERT_TRUE(camera->apply(bench_->settings()));
  start(*camera);
  expect_frames(*camera, 10);
}

TEST_P(CameraLossContract, ADeviceThatLostPowerDoesNotTakeASettingAsIfNothingHadHappened) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  expect_frames(*camera, 3);
  bench_->unplug();
  bench_->plug_in();  // with its power-up settings, before the loss was noticed
  CameraSettings wanted = bench_->settings();
  wanted.gain_db += 1.0;
  EXPECT_FALSE(camera->apply(wanted));
  EXPECT_FALSE(camera->alive());
  camera.reset();
  camera = reopen(seconds(10));
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->apply(wanted), wanted);
}

TEST_P(CameraLossContract, AnUnpluggedDeviceIsNoticedEvenIfNobodyCallsIt) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  expect_frames(*camera, 3);
  bench_->unplug();
  EXPECT_LT(timed("until alive is false",
                  [&] {
                    const auto end = monotonic_ns() + 20'000'000'000;
                    while (camera->alive() && monotonic_ns() < end)
                      std::this_thread::sleep_for(milliseconds(20));
                  }),
            kBoundSeconds);
  EXPECT_FALSE(camera->alive());
  EXPECT_LT(timed("stop and destructor", [&] { camera.reset(); }), kBoundSeconds);
}

TEST_P(CameraLossContract, UnpluggedWhileStoppingAtOnceIsBounded) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  expect_frames(*camera, 3);
  bench_->unplug();
  EXPECT_LT(timed("stop, not known yet", [&] { camera->stop(); }), kBoundSeconds);
  EXPECT_LT(timed("destructor", [&] { camera.reset(); }), kBoundSeconds);
}

TEST_P(CameraLossContract, AfterAFreezeTheObjectIsDeadAndANewOneWorks) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  expect_frames(*camera, 3);
  bench_->freeze();
  std::this_thread::sleep_for(seconds(7));
  bench_->thaw();
  const auto end = monotonic_ns() + 10'000'000'000;
  while (camera->alive() && monotonic_ns() < end) std::this_thread::sleep_for(milliseconds(20));
  EXPECT_FALSE(camera->alive());
  camera.reset();
  camera = reopen(seconds(15));
  ASSERT_TRUE(camera);
  ASSERT_TRUE(camera->apply(bench_->settings()));
  start(*camera);
  expect_frames(*camera, 10);
}

TEST_P(CameraLossContract, WhatACrashedProgramLeftRunningIsStoppedAndStartedAgain) {
  bench_->crash_a_client();
  auto camera = reopen(seconds(20));
  ASSERT_TRUE(camera);
  // Long enough for a device that was not stopped to continue sending to the crashed program.
  std::this_thread::sleep_for(milliseconds(300));
  ASSERT_TRUE(camera->apply(bench_->settings()));
  start(*camera);
  expect_frames(*camera, 20);
}

}  // namespace
}  // namespace ovws::testing
