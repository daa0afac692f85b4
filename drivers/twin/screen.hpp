/// Screen reader: watches the SLM's output on the X server and passes each new image to the bench.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>
#include <string>

#include "drivers/twin/bench.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

class XOutput;

/// Time in which a display usually answers Screen::catch_up.
constexpr auto kDisplayTime = std::chrono::milliseconds(200);

struct ScreenStatus {
  bool shown = false;          ///< the output exists and is being read
  std::string text;            ///< name of the output, or the reason why it cannot be read
  std::uint64_t grabs = 0;     ///< number of images read
  std::uint64_t connects = 0;  ///< how often the output was found
};

/// Reader of the SLM's image. While there is no display, the SLM is off: grey level 0 everywhere.
class Screen {
 public:
  /// `x_display`: name of the X display, e.g. ":1"; empty: the value of $DISPLAY.
  Screen(const Config& config, std::string x_display, Bench& bench);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  void work(const std::stop_token& stop);  ///< body of the screen's thread

  /// Waits until the bench has every image that the display showed before this call. Call it in any
  /// thread but the screen's. False on stop, or if the X server did not answer by the deadline.
  bool catch_up(Bench::Deadline deadline, const std::stop_token& stop);
  ScreenStatus status() const;  ///< thread-safe

 private:
  void follow(XOutput& output, const std::stop_token& stop);
  bool forward(XOutput& output, Patterns& patterns, Bench::Deadline since);
  void wait_for_events(int descriptor);
  void answer(std::uint64_t asked);
  std::uint64_t asked() const;
  void report(bool shown, const std::string& text);

  const SlmConfig slm_;
  const PatternMode dmd_;
  const std::string x_display_;
  Bench& bench_;
  int wake_fd_;  ///< eventfd that wakes the screen's thread
  mutable std::mutex mutex_;
  std::condition_variable_any answered_now_;
  std::uint64_t asked_ = 0, answered_ = 0;  ///< number of catch_up calls begun and answered
  ScreenStatus status_;
};

}  // namespace ovws::twin
