/// Camera contract: frames, buffers, and restarts.
#include <algorithm>
#include <set>

#include "core/base/pixels.hpp"
#include "tests/contract/camera/camera_contract.hpp"

namespace ovws::testing {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Expects every pixel to have the value that the device put there.
void expect_pixels(const CameraBench& bench, const ImageView& image, const Roi& roi) {
  ASSERT_EQ(image.width, roi.width);
  ASSERT_EQ(image.height, roi.height);
  ASSERT_NE(image.data, nullptr);
  int wrong = 0;
  visit_rows(image, 0, 0, image.width, image.height,
             [&](int x, int y, const auto* pixels, int count) {
               for (int i = 0; i < count; ++i) {
                 const auto expected = bench.pixel(image.format, roi.x + x + i, roi.y + y);
                 if (expected && pixels[i] != *expected) ++wrong;
               }
             });
  EXPECT_EQ(wrong, 0) << "of " << image.width * image.height;
}

TEST_P(CameraContract, TwoHundredFramesComeInOrder) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  const CameraSettings settings = bench_->settings();
  GrabbedFrame last;
  int in_order = 0;  // since the last gap that is not reported: a busy machine loses whole frames
  for (int i = 0; in_order < 200; ++i) {
    ASSERT_LT(i, 4000);
    std::uint64_t incomplete = 0;
    const GrabbedFrame frame = next_frame(*camera, &incomplete);
    ASSERT_GE(frame.slot, 0);
    ASSERT_LT(frame.slot, camera->buffer_count());
    if (i > 0) {
      ASSERT_GT(frame.frame_id, last.frame_id + incomplete) << "frame " << i;
      in_order = frame.frame_id == last.frame_id + 1 + incomplete ? in_order + 1 : 0;
      EXPECT_GT(frame.t_device_ns, last.t_device_ns);
      EXPECT_GE(frame.t_arrival_mono_ns, last.t_arrival_mono_ns);
    }
    EXPECT_LE(frame.t_arrival_mono_ns, monotonic_ns());
    EXPECT_LT(std::abs(frame.t_arrival_ns - utc_ns()), 5'000'000'000);
    EXPECT_EQ(frame.image.format, settings.pixel_format);
    if (i % 20 == 0) expect_pixels(*bench_, frame.image, settings.roi);
    camera->release(frame.slot);
    last = frame;
  }
}

TEST_P(CameraContract, EveryPixelFormatGivesItsPixels) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  for (PixelFormat format : limits->pixel_formats) {
    SCOPED_TRACE(std::string(pixel_format_name(format)));
    CameraSettings wanted = bench_->settings();
    wanted.pixel_format = format;
    ASSERT_TRUE(camera->apply(wanted));
    start(*camera);
    const GrabbedFrame frame = next_frame(*camera);
    ASSERT_GE(frame.slot, 0);
    EXPECT_EQ(frame.image.format, format);
    expect_pixels(*bench_, frame.image, wanted.roi);
    camera->release(frame.slot);
    camera->stop();
  }
}

TEST_P(CameraContract, WithEveryBufferHeldNoFrameComesAndAfterReleaseTheyComeAgain) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  std::set<int> held;
  GrabbedFrame frame;
  while (int(held.size()) < camera->buffer_count()) {
    frame = next_frame(*camera);
    ASSERT_GE(frame.slot, 0);
    EXPECT_TRUE(held.insert(frame.slot).second) << "slot " << frame.slot << " was lent twice";
  }
  for (int i = 0; i < 5; ++i) EXPECT_EQ(camera->grab(frame, milliseconds(50)), GrabStatus::timeout);
  for (int slot : held) camera->release(slot);
  expect_frames(*camera, 3 * camera->buffer_count());
}

TEST_P(CameraContract, GrabWaitsNoLongerThanItsTimeout) {
  auto camera = open_with([](CameraSettings& s) { s.frame_rate_hz = 1.0; });
  ASSERT_TRUE(camera);
  start(*camera);
  GrabbedFrame frame;
  while (camera->grab(frame, microseconds(0)) == GrabStatus::frame) camera->release(frame.slot);
  std::int64_t shortest_ns = std::chrono::nanoseconds(kPatience).count();  // a turn may be stopped
  for (int turn = 0; turn < 5; ++turn) {
    const auto begin = monotonic_ns();
    for (microseconds timeout : {microseconds(0), microseconds(-5), microseconds(1000)}) {
      const GrabStatus status = camera->grab(frame, timeout);
      EXPECT_NE(status, GrabStatus::incomplete);
      if (status == GrabStatus::frame) camera->release(frame.slot);
    }
    shortest_ns = std::min(shortest_ns, monotonic_ns() - begin);
  }
  EXPECT_LT(shortest_ns, 900'000'000);
}

TEST_P(CameraContract, DamagedFramesAreReportedAndTheirBuffersUsedAgain) {
  ASSERT_TRUE(bench_->lose_packets());
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  int whole = 0;
  int damaged = 0;
  GrabbedFrame frame;
  const auto end = monotonic_ns() + 60'000'000'000;
  while ((damaged < 3 * camera->buffer_count() || whole < 10) && monotonic_ns() < end) {
    const GrabStatus status = camera->grab(frame, kPatience);
    ASSERT_NE(status, GrabStatus::timeout);
    if (status == GrabStatus::incomplete) {
      ++damaged;
    } else {
      ++whole;
      expect_pixels(*bench_, frame.image, bench_->settings().roi);
      camera->release(frame.slot);
    }
  }
  EXPECT_GE(damaged, 3 * camera->buffer_count());
  EXPECT_GE(whole, 10);
}

TEST_P(CameraContract, StopsAndStartsAgainAndTheNumbersGoOn) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  std::uint64_t last = 0;
  for (int round = 0; round < 4; ++round) {
    const GrabbedFrame frame = next_frame(*camera);
    ASSERT_GE(frame.slot, 0);
    EXPECT_GT(frame.frame_id, last);
    last = frame.frame_id;
    camera->release(frame.slot);
    expect_frames(*camera, 3);
    camera->stop();
    start(*camera);
  }
}

TEST_P(CameraContract, StopIsHarmlessWithoutAStartAndTwice) {
  auto camera = open_ready();
  ASSERT_TRUE(camera);
  camera->stop();
  start(*camera);
  camera->stop();
  camera->stop();
  EXPECT_TRUE(camera->alive());
  start(*camera);
  expect_frames(*camera, 3);
}

TEST_P(CameraContract, ASecondStartIsRefused) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  auto again = camera->start();
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, Errc::refused);
  expect_frames(*camera, 3);
}

TEST_P(CameraContract, WhileStreamingTheFrameKeepsItsSizeUntilStopped) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  CameraSettings wanted = bench_->settings();
  wanted.roi = {32, 64, 96, 160};
  expect_refused(*camera, wanted, "camera.roi", {"stop"}, Errc::refused);
  auto limits = camera->limits();
  ASSERT_TRUE(limits);
  for (PixelFormat format : limits->pixel_formats) {
    if (format == bench_->settings().pixel_format) continue;
    CameraSettings other = bench_->settings();
    other.pixel_format = format;
    expect_refused(*camera, other, "camera.pixel_format", {"stop"}, Errc::refused);
  }
  expect_frames(*camera, 3);
  camera->stop();
  auto applied = camera->apply(wanted);
  ASSERT_TRUE(applied) << applied.error().reason;
  start(*camera);
  for (int i = 0; i < 20; ++i) {
    const GrabbedFrame frame = next_frame(*camera);
    ASSERT_GE(frame.slot, 0);
    expect_pixels(*bench_, frame.image, wanted.roi);
    camera->release(frame.slot);
  }
}

TEST_P(CameraContract, GainExposureAndRateChangeWhileFramesCome) {
  auto camera = open_streaming();
  ASSERT_TRUE(camera);
  CameraSettings wanted = bench_->settings();
  std::uint64_t last = 0;
  int in_order = 0;  // settings since the last gap: a busy machine loses frames
  for (int i = 0; in_order < 10; ++i) {
    ASSERT_LT(i, 200);
    wanted.*bench_->gain() = 1.0 + i % 5;
    wanted.exposure_us = 1000.0 + 50.0 * (i % 10);
    wanted.frame_rate_hz = i % 2 ? 100.0 : 125.0;
    auto applied = camera->apply(wanted);
    ASSERT_TRUE(applied) << applied.error().reason;
    ++in_order;
    for (int k = 0; k < 3; ++k) {
      const GrabbedFrame frame = next_frame(*camera);
      ASSERT_GE(frame.slot, 0);
      if (frame.frame_id != last + 1) in_order = 0;
      last = frame.frame_id;
      camera->release(frame.slot);
    }
  }
}

TEST_P(CameraContract, MayBeDestroyedWhileFramesComeAndOpenedAgain) {
  for (int i = 0; i < 3; ++i) {
    auto camera = open_streaming();
    ASSERT_TRUE(camera);
    expect_frames(*camera, 3);
  }
}

}  // namespace
}  // namespace ovws::testing
