/// The state of the bench that a screen shows: the newest message of each stream, parsed.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "proto/spot_rows.hpp"

namespace ovws::screen {

using Clock = std::chrono::steady_clock;

/// A loss counter of `status` that is not zero.
struct Loss {
  std::string name;
  std::uint64_t count = 0;  ///< since the daemon's start
  std::uint64_t grown = 0;  ///< increase since the previous status
};

struct View {
  bool status_is_current = false;
  double silent_s = 0.0;     ///< time since the last message
  nlohmann::json status;     ///< newest status message; null: none, or too old
  nlohmann::json wavefront;  ///< newest wavefront message; null: none, or too old
  std::string not_valid;     ///< why the wavefront is not valid; set by the caller
  std::vector<SpotRow> spots;
  std::vector<Loss> losses;           ///< loss counters that are not 0
  std::deque<nlohmann::json> events;  ///< event messages, the newest last
};

/// Keeps the newest messages of each topic. Ignores unknown topics, and a status or event that is
/// not a JSON object. After a wavefront that is not a JSON object, there is no wavefront to show.
class Gatherer {
 public:
  explicit Gatherer(Clock::time_point begin) : last_(begin) {}

  void take(const std::string& topic, std::string text, std::vector<std::byte> binary,
            Clock::time_point now);
  /// Parses the messages received since the last call. Omits a status older than 3 s and a
  /// wavefront older than some frames, so that stale values do not look live.
  const View& view(Clock::time_point now);

 private:
  void read_wavefront();
  void read_status(nlohmann::json status);
  bool frames_are_current(Clock::time_point now) const;

  View view_;
  std::string wavefront_;         ///< text as received; empty: already parsed
  std::vector<std::byte> spots_;  ///< as received
  std::map<std::string, std::uint64_t> counters_;
  Clock::time_point last_;
  std::optional<Clock::time_point> last_status_, last_frame_;
};

}  // namespace ovws::screen
