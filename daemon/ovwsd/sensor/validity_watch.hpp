/// Watches for periods without a valid frame: since when, why, and what the daemon does about it.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "proto/status_message.hpp"

namespace ovws {

/// Progress of the whole-image search. Times are CLOCK_MONOTONIC.
struct SearchProgress {
  bool running = false;
  int searches = 0;          ///< since frames were last valid
  std::int64_t next_ns = 0;  ///< next search of the unchanged image
};

/// Watches settled frames of a sensor with a reference. One thread calls `on_frame`; any thread may
/// call the rest.
class ValidityWatch {
 public:
  /// What is wrong with the newest invalid frame.
  struct Lack {
    std::int64_t since_ns = 0;  ///< start of the invalid period, CLOCK_MONOTONIC
    int tracked = 0, spots = 0;
    bool explained = true;  ///< false: no wavefront explains the spots' positions
    bool waits = false;     ///< the positions must be confirmed by templates first
  };

  void on_frame(bool valid, const Lack& lack, std::int64_t now_ns);

  /// None if the newest frame was valid, or if no frame came for 1.5 s, which has another cause.
  std::optional<Lack> lack(std::int64_t now_ns) const;
  /// Whether the newest frame was valid, or there was none yet.
  bool is_valid() const { return since_ns_ == 0; }

 private:
  std::atomic<std::int64_t> since_ns_{0};  ///< 0: the newest frame was valid
  std::atomic<std::int64_t> newest_ns_{0};
  std::atomic<int> tracked_{0}, spots_{0};
  std::atomic<bool> explained_{true}, waits_{false};
};

/// Describes an invalid period for status and events. `now_ns` (CLOCK_MONOTONIC) and `utc_ns` are
/// the same moment.
StatusMessage::SensorPart::Invalid invalid_in_words(const ValidityWatch::Lack& lack,
                                                    const SearchProgress& search,
                                                    std::int64_t now_ns, std::int64_t utc_ns);

}  // namespace ovws
