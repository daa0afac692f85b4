/// Hands a camera to the acquisition thread and takes it back, without a lock on the frame path.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>

#include "core/base/realtime.hpp"
#include "core/base/result.hpp"
#include "core/port/camera.hpp"

namespace ovws {

class CameraExchange {
 public:
  explicit CameraExchange(std::chrono::milliseconds patience = std::chrono::seconds(2))
      : patience_(patience) {}

  // Control side; thread-safe among each other. Both return when the acquisition thread no longer
  // uses the previous camera and has released all its buffers. After a time-out (`patience`) they
  // return Errc::unavailable with the cause; the request remains and may still be served later.
  Result<void> attach(Camera& camera) { return ask(&camera); }
  Result<void> detach() { return ask(nullptr); }

  // Acquisition thread.
  /// Once per iteration, with the number of buffers still lent. True: a request can be served now.
  bool due(int lent) OVWS_NONBLOCKING;
  /// Serves the request: switches to the requested camera. Only after `due` returned true.
  void follow() OVWS_NONBLOCKING;
  /// The camera that owns the lent buffers; nullptr: none.
  Camera* camera() const { return camera_; }
  /// Whether to take frames. False without a camera, and while a request waits for lent buffers.
  bool streaming() const { return camera_ != nullptr && !asked_for_other(); }

 private:
  bool asked_for_other() const { return seen_ != served_.load(std::memory_order_relaxed); }
  Result<void> ask(Camera* wanted);
  Error why_not(std::uint64_t turns_before) const;

  const std::chrono::milliseconds patience_;
  std::mutex control_;
  std::atomic<Camera*> wanted_{nullptr};
  std::atomic<std::uint64_t> asked_{0};
  std::atomic<std::uint64_t> served_{0};
  std::atomic<std::uint64_t> turns_{0};  ///< shows that the acquisition thread runs
  std::atomic<int> lent_{0};
  Camera* camera_ = nullptr;  ///< acquisition thread
  std::uint64_t seen_ = 0;    ///< acquisition thread: the request seen last
};

}  // namespace ovws
