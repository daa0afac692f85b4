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
  // Control side; thread-safe among each other. Both return when the acquisition thread has let go
  // of the camera before, with all its buffers given back. After 2 s they give up with
  // Errc::unavailable and say why; the request stands, and may yet be followed.
  Result<void> attach(Camera& camera) { return ask(&camera); }
  Result<void> detach() { return ask(nullptr); }

  // Acquisition thread.
  /// Once a turn, with the number of buffers still lent. True if the camera is another one now.
  bool serve(int lent) OVWS_NONBLOCKING;
  /// The camera to give buffers back to.
  Camera* camera() const { return camera_; }
  /// False: take no more frames, a request waits for the buffers.
  bool streaming() const { return camera_ != nullptr && !changing_; }

 private:
  Result<void> ask(Camera* wanted);

  std::mutex control_;
  std::atomic<Camera*> wanted_{nullptr};
  std::atomic<std::uint64_t> asked_{0};
  std::atomic<std::uint64_t> served_{0};
  std::atomic<std::uint64_t> turns_{0};  ///< proves that somebody turns the agent
  std::atomic<int> lent_{0};
  Camera* camera_ = nullptr;  ///< acquisition thread
  bool changing_ = false;     ///< acquisition thread
};

}  // namespace ovws
