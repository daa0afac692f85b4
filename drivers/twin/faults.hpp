/// Fault injection: a test orders a fault for a number of frames or for a time.
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
  freeze,      ///< the camera neither sends nor answers, then continues with its settings
  unplug,      ///< the camera leaves the network, then returns with its power-up settings
  duplicate,  ///< frames are sent twice with one frame number and time; the copy takes the place of
              ///< the next frame
  reorder,    ///< frames are sent after the frame that follows them
  slow_registers,  ///< every register write is acknowledged late; no frame is sent meanwhile
};

/// Order of a fault. Only one fault is active; a new order replaces it. A fault lasts for `frames`
/// (only if it affects single frames) or for `seconds`.
struct Fault {
  FaultKind kind = FaultKind::none;
  int frames = 0;  ///< number of frames; 0: the fault lasts for `seconds`
  double seconds = 0.0;
  double delay_ms = 0.0;
};

/// Whether a fault of this kind uses `delay_ms`.
constexpr bool takes_delay(FaultKind kind) {
  return kind == FaultKind::delay || kind == FaultKind::slow_registers;
}

enum class FrameFate { send, drop, incomplete, duplicate, reorder };

/// The active fault. Thread-safe.
class Faults {
 public:
  void order(const Fault& fault);
  Fault active() const;  ///< active fault with its remaining frames or seconds

  /// Returns what happens to a new frame. Aravis's thread calls this for each new frame, except
  /// while a duplicated or reordered frame is kept. Blocks during a freeze or delay, until it is
  /// over, `stop` is requested or a new fault is ordered.
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
