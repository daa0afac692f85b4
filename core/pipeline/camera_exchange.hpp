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
  explicit CameraExchange(std::chrono::milliseconds timeout = std::chrono::seconds(2))
      : timeout_(timeout) {}

  // Control side; attach and detach are thread-safe. They return when the acquisition thread no
  // longer uses the previous camera and has released all its buffers. After `timeout` they return
  // Errc::unavailable with the cause; the request remains and may still be served later.
  Result<void> attach(Camera& camera) { return request(&camera); }
  Result<void> detach() { return request(nullptr); }

  // Acquisition thread.
  /// Call it once per iteration, with the number of buffers still lent. Returns true if an attach
  /// or detach request can be served now.
  bool can_serve(int lent) OVWS_NONBLOCKING;
  /// Serves the request: switches to the requested camera. Call it only after `can_serve` returned
  /// true.
  void serve() OVWS_NONBLOCKING;
  /// The camera that owns the lent buffers; nullptr: no camera is attached.
  Camera* camera() const { return camera_; }
  /// Whether to grab frames. False without a camera, and while a request waits for lent buffers.
  bool streaming() const { return camera_ != nullptr && !request_pending(); }

 private:
  bool request_pending() const { return seen_ != served_.load(std::memory_order_relaxed); }
  Result<void> request(Camera* camera);
  Error timeout_error(std::uint64_t iterations_before) const;

  const std::chrono::milliseconds timeout_;
  std::mutex control_;
  std::atomic<Camera*> requested_camera_{nullptr};
  std::atomic<std::uint64_t> requested_{0};
  std::atomic<std::uint64_t> served_{0};
  std::atomic<std::uint64_t> iterations_{0};  ///< shows that the acquisition thread runs
  std::atomic<int> lent_{0};
  Camera* camera_ = nullptr;  ///< acquisition thread
  std::uint64_t seen_ = 0;    ///< acquisition thread: the request seen last
};

}  // namespace ovws
