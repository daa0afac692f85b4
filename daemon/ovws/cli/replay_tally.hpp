/// Counts of replayed frames, and their summary.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace ovws::cli {

struct ReplayTally {
  std::uint64_t frames = 0, replayed = 0, same = 0, valid = 0, refined = 0;
  std::string first_reason, first_difference;

  /// Counts one frame, as `ovws replay --frames` prints it.
  void count(const nlohmann::json& line);
  nlohmann::json content() const;
  /// The summary for people. `name`: the recording.
  std::string text(const std::string& name) const;
};

}  // namespace ovws::cli
