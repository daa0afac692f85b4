/// Times of the display's refreshes, as the X server reports them (PRESENT extension).
#pragma once

#include <cstdint>
#include <memory>

namespace ovws::sdl {

/// Refreshes of the output that shows a window. Those that the server reported tell when the next
/// one is due: servers without hardware count a refresh from half a period before it on, so that a
/// request for the next one may be answered a period late. It has a connection of its own, which
/// outlives a server that ends. Main thread only.
class RefreshClock {
 public:
  /// `refresh_hz` of the window's output, > 0. Null: the server has no PRESENT extension, or does
  /// not answer.
  static std::unique_ptr<RefreshClock> open(std::uint32_t x_window, double refresh_hz);
  ~RefreshClock();
  RefreshClock(const RefreshClock&) = delete;
  RefreshClock& operator=(const RefreshClock&) = delete;

  /// Waits for the beginning of the next vertical blank. Returns its time, CLOCK_MONOTONIC in ns;
  /// 0: no refresh was reported within 0.1 s (the output is off, or the server has ended).
  std::int64_t wait();

 private:
  struct Impl;
  explicit RefreshClock(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws::sdl
