/// Fault injection: faults that a test orders, for a number of frames or a time.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <stop_token>

namespace ovws::twin {

enum class FaultKind {
  none,        ///< ends the active fault
  drop,        ///< frames are numbered but not sent
  incomplete,  ///< frames are sent with about half of their packets missing
  delay,       ///< frames are sent late; the camera does not answer meanwhile
  freeze,      ///< the camera neither sends nor answers, then continues as before
  unplug,      ///< the camera leaves the network, then returns with its power-up settings
  duplicate,  ///< frames are sent twice, with the same number and time, the second time in place of
              ///< the next frame
  reorder,    ///< frames are sent after their successor
  slow_registers,  ///< every register write is acknowledged late; no frame is sent meanwhile
};

/// One fault at a time; an order replaces the active one. It lasts for `frames` (faults of frames
/// only) or for `seconds` (any fault).
struct Fault {
  FaultKind kind = FaultKind::none;
  int frames = 0;  ///< 0: for `seconds`
  double seconds = 0.0;
  double delay_ms = 0.0;
};

/// Whether this fault uses `delay_ms`.
constexpr bool takes_delay(FaultKind kind) {
  return kind == FaultKind::delay || kind == FaultKind::slow_registers;
}

enum class FrameFate { send, drop, incomplete, duplicate, reorder };

/// Thread-safe.
class Faults {
 public:
  void order(const Fault& fault);
  Fault active() const;  ///< with its remaining frames or seconds

  /// Called once per frame in the camera thread. Blocks during a freeze or delay (shorter on stop
  /// or a new order), then returns what happens to the frame.
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
