/// Watches the SLM's display and tells the bench what it shows, for as long as the twin runs.
#pragma once

#include <cstdint>
#include <mutex>
#include <stop_token>
#include <string>

#include "drivers/twin/bench.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

class XOutput;

struct ScreenStatus {
  bool shown = false;          ///< the output is there and being read
  std::string text;            ///< what is read, or why there is nothing to read
  std::uint64_t grabs = 0;     ///< pictures read
  std::uint64_t connects = 0;  ///< times that the output was found
};

/// While the display is away the SLM is off: flat, grey level 0 everywhere.
class Screen {
 public:
  /// `x_display`: ":1"; empty: $DISPLAY.
  Screen(const SlmConfig& slm, std::string x_display, Bench& bench);

  void work(const std::stop_token& stop);  ///< body of the screen's thread
  ScreenStatus status() const;             ///< thread-safe

 private:
  void follow(XOutput& output, const std::stop_token& stop);
  void report(bool shown, const std::string& text);

  const SlmConfig slm_;
  const std::string x_display_;
  Bench& bench_;
  mutable std::mutex mutex_;
  ScreenStatus status_;
};

}  // namespace ovws::twin
