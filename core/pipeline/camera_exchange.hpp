/// Gives the acquisition thread a camera and takes it away again, with neither waiting for a lock.
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

  // Control side; thread-safe among each other. Both return when the acquisition thread has let go
  // of the camera before, with all its buffers given back. Out of patience they give up with
  // Errc::unavailable and say why; the request stands, and may yet be followed.
  Result<void> attach(Camera& camera) { return ask(&camera); }
  Result<void> detach() { return ask(nullptr); }

  // Acquisition thread.
  /// Once a turn, with the number of buffers still lent. True: a request can be followed now.
  bool due(int lent) OVWS_NONBLOCKING;
  /// Takes the camera that was asked for, and says so. Only after `due`.
  void follow() OVWS_NONBLOCKING;
  /// The camera to give buffers back to.
  Camera* camera() const { return camera_; }
  /// False: take no more frames, a request waits for the buffers.
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
  std::atomic<std::uint64_t> turns_{0};  ///< proves that somebody turns the agent
  std::atomic<int> lent_{0};
  Camera* camera_ = nullptr;  ///< acquisition thread
  std::uint64_t seen_ = 0;    ///< acquisition thread: the request seen last
};

}  // namespace ovws
