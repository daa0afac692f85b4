/// The handshake: a numbered request, served once no buffer is lent any more.
#include "core/pipeline/camera_exchange.hpp"

#include <string>
#include <thread>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::int64_t kPatienceNs = 2'000'000'000;
constexpr std::chrono::microseconds kPoll{500};

}  // namespace

Result<void> CameraExchange::ask(Camera* wanted) {
  const std::lock_guard lock(control_);
  wanted_.store(wanted, std::memory_order_relaxed);
  const std::uint64_t mine = asked_.load(std::memory_order_relaxed) + 1;
  asked_.store(mine, std::memory_order_release);
  const std::uint64_t turns_before = turns_.load(std::memory_order_relaxed);
  const std::int64_t give_up_ns = monotonic_ns() + kPatienceNs;
  while (served_.load(std::memory_order_acquire) < mine) {
    if (monotonic_ns() > give_up_ns) {
      if (turns_.load(std::memory_order_relaxed) == turns_before) {
        return fail(Errc::unavailable, "camera",
                    "the acquisition thread did not run for 2 s: start it, or look in the log why "
                    "it stands still");
      }
      return fail(Errc::unavailable, "camera",
                  std::to_string(lent_.load(std::memory_order_relaxed)) +
                      " camera buffers are still in use after 2 s: release the images that were "
                      "asked for, and see that the tracker threads run");
    }
    std::this_thread::sleep_for(kPoll);
  }
  return {};
}

bool CameraExchange::serve(int lent) OVWS_NONBLOCKING {
  turns_.fetch_add(1, std::memory_order_relaxed);
  lent_.store(lent, std::memory_order_relaxed);
  const std::uint64_t asked = asked_.load(std::memory_order_acquire);
  changing_ = asked != served_.load(std::memory_order_relaxed);
  if (!changing_ || lent > 0) return false;
  // A newer request may have replaced `wanted_` since `asked` was read: then this takes its camera
  // early, and the next turn serves it again.
  camera_ = wanted_.load(std::memory_order_relaxed);
  changing_ = false;
  served_.store(asked, std::memory_order_release);
  return true;
}

}  // namespace ovws
