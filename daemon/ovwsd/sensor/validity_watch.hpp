/// Watches for periods without a valid frame: since when, why, and what the daemon does about it.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// Progress of the search for the wavefront. Times are CLOCK_MONOTONIC.
struct SearchProgress {
  bool running = false;
  int searches = 0;          ///< since frames were last valid
  std::int64_t next_ns = 0;  ///< next search of the unchanged image
};

/// Watches settled frames of a sensor with a reference. One thread calls `on_frame`, one calls
/// `announce` and the methods of the search; any thread may call the rest.
class ValidityWatch {
 public:
  /// What is wrong with the newest invalid frame.
  struct Lack {
    std::int64_t since_ns = 0;  ///< start of the invalid period, CLOCK_MONOTONIC
    int tracked = 0, spots = 0;
    bool explained = true;  ///< false: no wavefront explains the spots' positions
    bool waits = false;     ///< the positions must be confirmed by templates first
    bool searched = true;   ///< the tracker is `fit`, so that the wavefront is searched
  };

  void on_frame(bool valid, const Lack& lack, std::int64_t now_ns);

  /// None if the newest frame was valid, or if no frame came for 1.5 s, which has another cause.
  std::optional<Lack> lack(std::int64_t now_ns) const;
  /// Whether the newest frame was valid, or there was none yet.
  bool is_valid() const { return since_ns_ == 0; }
  /// Describes the lack for status and events; none if there is none. `now_ns` (CLOCK_MONOTONIC)
  /// and `utc_ns` are the same moment.
  std::optional<StatusMessage::SensorPart::Invalid> why_invalid(std::int64_t now_ns,
                                                                std::int64_t utc_ns) const;

  void search_begins();
  void search_failed(std::int64_t next_ns);
  void search_succeeded() { progress_.set({}); }
  /// Publishes an event when no frame has been valid for half a second, and when frames are valid
  /// again.
  void announce(Events& events, std::int64_t now_ns);

 private:
  std::atomic<std::int64_t> since_ns_{0};  ///< 0: the newest frame was valid
  std::atomic<std::int64_t> newest_ns_{0};
  std::atomic<int> tracked_{0}, spots_{0};
  std::atomic<bool> explained_{true}, waits_{false}, searched_{true};
  Guarded<SearchProgress> progress_;
  std::int64_t announced_ns_ = 0;  ///< start of the announced invalid period; 0: none
};

/// Describes an invalid period for status and events. `now_ns` (CLOCK_MONOTONIC) and `utc_ns` are
/// the same moment.
StatusMessage::SensorPart::Invalid invalid_in_words(const ValidityWatch::Lack& lack,
                                                    const SearchProgress& search,
                                                    std::int64_t now_ns, std::int64_t utc_ns);

}  // namespace ovws
