/// Camera hand-over: requests are numbered and served once no camera buffer is lent.
#include "core/pipeline/camera_exchange.hpp"

#include <string>
#include <thread>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::chrono::microseconds kPoll{500};

}  // namespace

Result<void> CameraExchange::request(Camera* camera) {
  const std::lock_guard lock(control_);
  // Memory order release: a thread that loads this pointer also sees the camera as it is now, even
  // if it has not yet seen the new `requested_` (see `serve`).
  requested_camera_.store(camera, std::memory_order_release);
  const std::uint64_t mine = requested_.load(std::memory_order_relaxed) + 1;
  requested_.store(mine, std::memory_order_release);
  const std::uint64_t iterations_before = iterations_.load(std::memory_order_relaxed);
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(timeout_).count();
  while (served_.load(std::memory_order_acquire) < mine) {
    if (monotonic_ns() > give_up_ns) return fail(timeout_error(iterations_before));
    std::this_thread::sleep_for(kPoll);
  }
  return {};
}

Error CameraExchange::timeout_error(std::uint64_t iterations_before) const {
  const std::string waited = std::to_string(timeout_.count()) + " ms";
  if (iterations_.load(std::memory_order_relaxed) == iterations_before) {
    return {Errc::unavailable, "camera",
            "the acquisition thread did not run for " + waited +
                ": look for the cause in the log, and restart the daemon if it does not recover"};
  }
  return {Errc::unavailable, "camera",
          std::to_string(lent_.load(std::memory_order_relaxed)) +
              " camera buffers are still in use after " + waited +
              ": look in the log for a thread that hangs, and restart the daemon if it does not "
              "recover"};
}

bool CameraExchange::can_serve(int lent) OVWS_NONBLOCKING {
  iterations_.fetch_add(1, std::memory_order_relaxed);
  lent_.store(lent, std::memory_order_relaxed);
  seen_ = requested_.load(std::memory_order_acquire);
  return request_pending() && lent == 0;
}

void CameraExchange::serve() OVWS_NONBLOCKING {
  // A newer request may have replaced `requested_camera_` since `can_serve`. The newer camera is
  // then taken early here, and once more on the next iteration.
  camera_ = requested_camera_.load(std::memory_order_acquire);
  served_.store(seen_, std::memory_order_release);
}

}  // namespace ovws
