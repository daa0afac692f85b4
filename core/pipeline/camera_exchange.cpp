/// The handshake: numbered requests, served once no camera buffer is lent.
#include "core/pipeline/camera_exchange.hpp"

#include <string>
#include <thread>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::chrono::microseconds kPoll{500};

}  // namespace

Result<void> CameraExchange::ask(Camera* wanted) {
  const std::lock_guard lock(control_);
  // Release: the thread that loads this pointer sees the camera as it is now, even if it has not
  // yet seen `asked_` (see `follow`).
  wanted_.store(wanted, std::memory_order_release);
  const std::uint64_t mine = asked_.load(std::memory_order_relaxed) + 1;
  asked_.store(mine, std::memory_order_release);
  const std::uint64_t turns_before = turns_.load(std::memory_order_relaxed);
  const std::int64_t give_up_ns = monotonic_ns() + std::chrono::nanoseconds(patience_).count();
  while (served_.load(std::memory_order_acquire) < mine) {
    if (monotonic_ns() > give_up_ns) return fail(why_not(turns_before));
    std::this_thread::sleep_for(kPoll);
  }
  return {};
}

Error CameraExchange::why_not(std::uint64_t turns_before) const {
  const std::string waited = std::to_string(patience_.count()) + " ms";
  if (turns_.load(std::memory_order_relaxed) == turns_before) {
    return {Errc::unavailable, "camera",
            "the acquisition thread did not run for " + waited +
                ": look for the cause in the log, and restart the daemon if it does not recover"};
  }
  return {Errc::unavailable, "camera",
          std::to_string(lent_.load(std::memory_order_relaxed)) +
              " camera buffers are still in use after " + waited +
              ": release the requested images, and check that the tracker threads run"};
}

bool CameraExchange::due(int lent) OVWS_NONBLOCKING {
  turns_.fetch_add(1, std::memory_order_relaxed);
  lent_.store(lent, std::memory_order_relaxed);
  seen_ = asked_.load(std::memory_order_acquire);
  return asked_for_other() && lent == 0;
}

void CameraExchange::follow() OVWS_NONBLOCKING {
  // A newer request may have replaced `wanted_` since `due`. Its camera is then taken early here
  // and again on the next iteration.
  camera_ = wanted_.load(std::memory_order_acquire);
  served_.store(seen_, std::memory_order_release);
}

}  // namespace ovws
