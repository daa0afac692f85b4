/// Repeats the decisions of a closed loop from its recording.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/result.hpp"
#include "drivers/replay/recording_reader.hpp"

namespace ovws {

struct PlayedLoop {
  int runs = 0;                           ///< how often the loop was closed
  std::uint64_t decisions = 0, same = 0;  ///< repeated; with the recorded correction bit by bit
  std::string first_difference;           ///< empty: none
  std::string reason;                     ///< why not all decisions were repeated; empty: all were
};

/// Gives the control laws the recorded coefficients again, and compares their corrections with
/// those in the recorded plans. Errors: the file is damaged.
Result<PlayedLoop> replay_loop(RecordingReader& reader);

}  // namespace ovws
