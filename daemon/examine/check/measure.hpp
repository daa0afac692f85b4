/// The measurements of `ovws check`, as a client of a daemon.
#pragma once

#include <functional>
#include <string>

#include "daemon/examine/check/measured.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::examine {

struct Options {
  double seconds = 60.0;   ///< of the record with the loop open
  bool quick = false;      ///< fewer frames, no look-up table, at most 10 s of record
  bool open_loop = false;  ///< opens a closed loop, and closes it again at the end
  bool close_loop = true;  ///< whether the loop may be closed for some seconds
};

/// Called from the thread that measures.
struct Hooks {
  std::function<bool()> interrupted = [] { return false; };
  std::function<void(const std::string& text, double seconds_left)> progress =
      [](const std::string&, double) {};
};

/// Measures for `seconds` and one or two minutes more. Restores on return, also after an error or
/// an interrupt, all that it has changed: aberration, loop, correction and look-up table. Errors:
/// the daemon refuses or does not answer; no reference; a closed loop without `open_loop`; another
/// pattern than the sensor; another job is running; an interrupt.
tl::expected<Measured, cli::CallFailure> measure(const cli::Common& common, const Options& options,
                                                 const Hooks& hooks);

}  // namespace ovws::examine
