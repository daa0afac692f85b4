/// What a screen shows of a bench: the newest of every message, read.
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

namespace ovws::screen {

using Clock = std::chrono::steady_clock;

struct SpotRow {
  float x = 0, y = 0, ref_x = 0, ref_y = 0;  ///< camera pixels; NaN: lost, no reference
};

/// What counts as lost, by the counter's name in `status`.
struct Loss {
  std::string name;
  std::uint64_t count = 0;  ///< since the daemon's start
  std::uint64_t grown = 0;  ///< from the status before
};

struct View {
  bool daemon_tells = false;
  double silent_s = 0.0;     ///< since the last message; if it does not tell
  nlohmann::json status;     ///< null: none, or too old
  nlohmann::json wavefront;  ///< likewise
  std::string not_valid;     ///< why the wavefront is not valid; for the caller to say
  std::vector<SpotRow> spots;
  std::vector<Loss> losses;           ///< those that are not 0
  std::deque<nlohmann::json> events;  ///< the newest last
};

/// Keeps the newest messages; a message in a form that is not known is nothing to it.
class Gatherer {
 public:
  explicit Gatherer(Clock::time_point begin) : last_(begin) {}

  void take(const std::string& topic, std::string text, std::vector<std::byte> binary,
            Clock::time_point now);
  /// Reads what is new since the last call. A status of more than some seconds, and a wavefront of
  /// more than some frames ago are left out: what is old must not look live.
  const View& view(Clock::time_point now);

 private:
  void read_wavefront();
  void read_spots();
  void read_status(nlohmann::json status);
  bool frames_come(Clock::time_point now) const;

  View view_;
  std::string wavefront_, spots_;  ///< as they came; empty: read
  std::vector<std::byte> spots_binary_;
  std::map<std::string, std::uint64_t> counters_;
  Clock::time_point last_;
  std::optional<Clock::time_point> last_status_, last_frame_;
};

}  // namespace ovws::screen
