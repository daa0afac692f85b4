/// Since when no frame has been valid, why, and what is done about it.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "proto/tables/status.hpp"

namespace ovws {

/// What the search of whole images does. Times are CLOCK_MONOTONIC.
struct SearchProgress {
  bool running = false;
  int searches = 0;          ///< since frames were valid last
  std::int64_t next_ns = 0;  ///< of the same image
};

/// Counts settled frames of a sensor with a reference. One thread calls `saw`, any other the rest.
class ValidityWatch {
 public:
  /// What the newest of the invalid frames lacks.
  struct Lack {
    std::int64_t since_ns = 0;  ///< CLOCK_MONOTONIC, of the first one
    int tracked = 0, spots = 0;
    bool explained = true;  ///< false: no wavefront explains where the spots are
  };

  void saw(bool valid, const Lack& lack, std::int64_t now_ns);

  /// Nothing if the newest frame was valid, or none came for 1.5 s: then something else is wrong.
  std::optional<Lack> lack(std::int64_t now_ns) const;
  /// Whether the newest frame was, or none came yet.
  bool is_valid() const { return since_ns_ == 0; }

 private:
  std::atomic<std::int64_t> since_ns_{0};  ///< 0: the newest frame was valid
  std::atomic<std::int64_t> newest_ns_{0};
  std::atomic<int> tracked_{0}, spots_{0};
  std::atomic<bool> explained_{true};
};

/// In words. `now_ns` CLOCK_MONOTONIC, `utc_ns` the same moment.
StatusMessage::SensorPart::Invalid invalid_in_words(const ValidityWatch::Lack& lack,
                                                    const SearchProgress& search,
                                                    std::int64_t now_ns, std::int64_t utc_ns);

}  // namespace ovws
