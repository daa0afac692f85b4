/// A camera that sends scripted frames and fails the test on misuse of buffers.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/image.hpp"
#include "core/port/camera.hpp"

namespace ovws::test {

struct ScriptedFrame {
  std::uint64_t frame_id = 0;
  std::int64_t t_arrival_mono_ns = 0;
  std::shared_ptr<const Image<std::uint8_t>> image;
  bool incomplete = false;
  PixelFormat format = PixelFormat::mono8;
  std::int64_t t_device_ns = 0;
  GrabStatus status = GrabStatus::frame;
};

/// Each buffer is a copy of the frame's pixels. A released one is overwritten, so that a read after
/// release gives wrong pixels.
class ScriptedCamera final : public Camera {
 public:
  ScriptedCamera(int buffers, std::size_t bytes)
      : buffers_(std::size_t(buffers), std::vector<std::uint8_t>(bytes)),
        lent_(std::size_t(buffers), false) {}

  void send(ScriptedFrame frame) {
    const std::lock_guard lock(mutex_);
    script_.push_back(std::move(frame));
  }
  bool all_sent() const {
    const std::lock_guard lock(mutex_);
    return script_.empty();
  }
  int lent() const {
    const std::lock_guard lock(mutex_);
    return int(std::count(lent_.begin(), lent_.end(), true));
  }

  const CameraInfo& info() const override { return info_; }
  Result<CameraLimits> limits() override { return CameraLimits{}; }
  Result<CameraSettings> apply(const CameraSettings& wanted) override { return wanted; }
  Result<void> start() override { return {}; }
  void stop() override {}
  bool alive() const override { return true; }
  int buffer_count() const override { return int(buffers_.size()); }

  GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout) override {
    std::unique_lock lock(mutex_);
    const auto free = std::find(lent_.begin(), lent_.end(), false);
    if (script_.empty() || free == lent_.end()) {
      lock.unlock();
      std::this_thread::sleep_for(std::min(timeout, std::chrono::microseconds(100)));
      return GrabStatus::timeout;
    }
    const ScriptedFrame frame = std::move(script_.front());
    script_.pop_front();
    if (frame.incomplete) return GrabStatus::incomplete;
    if (frame.status != GrabStatus::frame) return frame.status;
    const auto slot = int(free - lent_.begin());
    lent_[std::size_t(slot)] = true;
    fill(out, frame, slot);
    return GrabStatus::frame;
  }

  void release(int slot) override {
    const std::lock_guard lock(mutex_);
    ASSERT_TRUE(slot >= 0 && slot < int(lent_.size()) && lent_[std::size_t(slot)])
        << "slot " << slot << " was not lent";
    lent_[std::size_t(slot)] = false;
    std::fill(buffers_[std::size_t(slot)].begin(), buffers_[std::size_t(slot)].end(), 0xEE);
  }

 private:
  void fill(GrabbedFrame& out, const ScriptedFrame& frame, int slot) {
    auto& buffer = buffers_[std::size_t(slot)];
    const auto& pixels = frame.image->pixels;
    std::memcpy(buffer.data(), pixels.data(), std::min(buffer.size(), pixels.size()));
    const int width = frame.image->width;
    out.image = {reinterpret_cast<const std::byte*>(buffer.data()), width, frame.image->height,
                 width, frame.format};
    out.frame_id = frame.frame_id;
    out.t_arrival_mono_ns = frame.t_arrival_mono_ns;
    out.t_device_ns = frame.t_device_ns;
    out.slot = slot;
  }

  mutable std::mutex mutex_;
  std::deque<ScriptedFrame> script_;
  std::vector<std::vector<std::uint8_t>> buffers_;
  std::vector<bool> lent_;
  CameraInfo info_;
};

}  // namespace ovws::test
