/// Fixture of the camera port's contract tests; every driver adds one or more parameter rows.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <ostream>
#include <vector>

#include "core/port/clock.hpp"
#include "tests/contract/camera/camera_bench.hpp"

namespace ovws::testing {

inline void PrintTo(const CameraRow& row, std::ostream* out) {
  *out << row.name;
}

/// Long enough for any frame of the bench's settings on a busy machine.
inline constexpr std::chrono::milliseconds kPatience{20'000};

class CameraContract : public ::testing::TestWithParam<CameraRow> {
 protected:
  void SetUp() override { bench_ = GetParam().make(); }

  /// Opens the camera and applies the bench's settings, modified by `change`.
  template <class Change>
  std::unique_ptr<Camera> open_with(Change change) {
    auto camera = bench_->open();
    if (!camera) {
      ADD_FAILURE() << "open: " << camera.error().field << ": " << camera.error().reason;
      return nullptr;
    }
    CameraSettings settings = bench_->settings();
    change(settings);
    auto applied = (*camera)->apply(settings);
    if (!applied) {
      ADD_FAILURE() << "apply: " << applied.error().field << ": " << applied.error().reason;
      return nullptr;
    }
    return std::move(*camera);
  }
  std::unique_ptr<Camera> open_ready() {
    return open_with([](CameraSettings&) {});
  }
  std::unique_ptr<Camera> open_streaming() {
    auto camera = open_ready();
    if (camera) start(*camera);
    return camera;
  }
  void start(Camera& camera) {
    auto started = camera.start();
    ASSERT_TRUE(started) << started.error().reason;
  }

  /// Grabs the next complete frame; fails the test if none comes.
  /// `incomplete`: counts the incomplete frames before it, which a busy machine may cause.
  GrabbedFrame next_frame(Camera& camera, std::uint64_t* incomplete = nullptr) {
    GrabbedFrame frame;
    const auto end = monotonic_ns() + std::chrono::nanoseconds(kPatience).count();
    while (monotonic_ns() < end) {
      const GrabStatus status = camera.grab(frame, kPatience);
      if (status == GrabStatus::frame) return frame;
      if (status == GrabStatus::incomplete && incomplete != nullptr) ++*incomplete;
    }
    ADD_FAILURE() << "no frame came";
    return {};
  }
  void expect_frames(Camera& camera, int count) {
    for (int i = 0; i < count && !HasFailure(); ++i) {
      const GrabbedFrame frame = next_frame(camera);
      if (frame.slot >= 0) camera.release(frame.slot);
    }
  }

  /// Expects that `wanted` is refused for `field`, with all of `words` in the reason, and that
  /// nothing changes.
  void expect_refused(Camera& camera, const CameraSettings& wanted, const std::string& field,
                      const std::vector<std::string>& words, Errc code = Errc::invalid) {
    const auto before = bench_->truth();
    auto applied = camera.apply(wanted);
    ASSERT_FALSE(applied) << field;
    EXPECT_EQ(applied.error().code, code) << applied.error().reason;
    EXPECT_EQ(applied.error().field, field) << applied.error().reason;
    for (const std::string& word : words)
      EXPECT_NE(applied.error().reason.find(word), std::string::npos)
          << "no '" << word << "' in: " << applied.error().reason;
    EXPECT_EQ(bench_->truth(), before) << field;
  }

  /// Opens the camera again as soon as the device has released its last controller.
  std::unique_ptr<Camera> reopen(std::chrono::seconds patience) {
    const auto end = monotonic_ns() + std::chrono::nanoseconds(patience).count();
    for (;;) {
      auto camera = bench_->open();
      if (camera) return std::move(*camera);
      EXPECT_EQ(camera.error().code, Errc::unavailable) << camera.error().reason;
      if (monotonic_ns() > end || HasFailure()) {
        ADD_FAILURE() << "open: " << camera.error().reason;
        return nullptr;
      }
    }
  }

  std::unique_ptr<CameraBench> bench_;
};

/// For drivers whose device can be unplugged. Slow, because a device that does not answer takes
/// seconds.
class CameraLossContract : public CameraContract {};

}  // namespace ovws::testing
