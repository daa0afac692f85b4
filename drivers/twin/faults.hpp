/// What goes wrong on purpose: faults that a test orders, for a number of frames or a time.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>

namespace ovws::twin {

enum class FaultKind {
  none,        ///< ends the fault that is on
  drop,        ///< frames taken, numbered and not sent
  incomplete,  ///< frames sent with about half of their packets missing
  delay,       ///< frames sent late; the camera answers nothing meanwhile
  freeze,      ///< the camera sends and answers nothing, then goes on as if nothing had been
  unplug,      ///< the camera is off the network, then comes back with its power-up settings
  duplicate,   ///< frames sent twice: again, number and stamp and all, in the next frame's place
  reorder,     ///< frames sent after the one that follows them
  slow_registers,  ///< every register write is acknowledged late; no frame is sent meanwhile
};

/// One fault at a time: ordering one ends the other. `frames` for what befalls frames, or `seconds`
/// for each of them.
struct Fault {
  FaultKind kind = FaultKind::none;
  int frames = 0;  ///< 0: for `seconds`
  double seconds = 0.0;
  double delay_ms = 0.0;
};

/// Whether `delay_ms` belongs to it.
constexpr bool takes_delay(FaultKind kind) {
  return kind == FaultKind::delay || kind == FaultKind::slow_registers;
}

enum class FrameFate { send, drop, incomplete, duplicate, reorder };

/// Thread-safe.
class Faults {
 public:
  void order(const Fault& fault);
  Fault active() const;  ///< with what is left of it

  /// Camera thread, once a frame: waits as long as a freeze or a delay lasts (less on stop or when
  /// another fault is ordered), then says what becomes of the frame.
  FrameFate next_frame(const std::stop_token& stop);
  bool unplugged() const;

 private:
  using Clock = std::chrono::steady_clock;
  Fault current() const;  // call with mutex_ locked

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  Fault fault_;
  Clock::time_point until_;
  std::uint64_t orders_ = 0;
};

}  // namespace ovws::twin
