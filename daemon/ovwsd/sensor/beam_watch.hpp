/// Watches whether the frames of the further light sources are valid.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/pipeline/frame_record.hpp"
#include "daemon/ovwsd/actor/events.hpp"

namespace ovws {

class BeamWatch {
 public:
  explicit BeamWatch(const std::vector<BeamConfig>& beams);

  /// Publish thread: call for every frame. Does not allocate.
  void on_frame(const FrameRecord& main);
  /// Any thread: why frames of source k are not valid; none if they are, if the source has no
  /// reference, or if no settled frame came for 1.5 s. Times are CLOCK_MONOTONIC.
  std::optional<std::string> why_invalid(std::size_t k, std::int64_t now_ns) const;
  /// One thread: publishes an event when a source has had no valid frame for half a second, and
  /// when its frames are valid again.
  void announce(Events& events, std::int64_t now_ns);

 private:
  static constexpr int kNone = -2, kMain = -1;

  struct One {
    explicit One(std::string of) : name(std::move(of)) {}
    const std::string name;
    std::atomic<std::int64_t> since_ns{0};  ///< 0: the newest frame was valid
    std::atomic<std::int64_t> newest_ns{0};
    std::atomic<int> tracked{0}, spots{0};
    std::atomic<bool> explained{true};
    std::atomic<int> too_close_to{kNone};  ///< kMain, or the number of another further source
    std::int64_t announced_ns = 0;         ///< start of the invalid period announced; 0: none is
  };

  static int too_close_to(const FrameRecord& main, std::size_t k);
  std::string lack_of(const One& one) const;

  std::deque<One> all_;
};

}  // namespace ovws
