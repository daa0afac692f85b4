/// Watches whether the frames of the further light sources are valid.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/rt/seq_lock.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"

namespace ovws {

class BeamWatch {
 public:
  BeamWatch(const std::vector<BeamConfig>& beams, FrameTaps& frames);

  /// Any thread: why frames of source k are not valid; none if they are, if the source has no
  /// reference, or if no settled frame came for 1.5 s. Times are CLOCK_MONOTONIC.
  std::optional<std::string> why_invalid(std::size_t k, std::int64_t now_ns) const;
  /// One thread: publishes an event when a source has had no valid frame for half a second, and
  /// when its frames are valid again.
  void announce(Events& events, std::int64_t now_ns);

 private:
  static constexpr int kNone = -2, kMain = -1;

  /// One frame's facts, which readers see together.
  struct Newest {
    std::int64_t since_ns = 0;  ///< start of the invalid period; 0: the newest frame was valid
    std::int64_t t_ns = 0;      ///< of the newest settled frame
    int tracked = 0, spots = 0;
    bool explained = true;
    bool enough_found = true;  ///< see enough_found of frame_rules.hpp
    int too_close_to = kNone;  ///< kMain, or the number of another further source
  };
  struct One {
    explicit One(const BeamConfig& of) : name(of.name) {}
    const std::string name;
    Newest written;  ///< publish thread only: what it wrote last into `newest`
    SeqLock<Newest> newest;
    std::int64_t announced_ns = 0;  ///< start of the invalid period announced; 0: none is
  };

  void on_frame(const FrameRecord& main);
  static int too_close_to(const FrameRecord& main, std::size_t k);
  std::optional<std::string> reason_of(const Newest& newest, std::int64_t now_ns) const;
  std::string lack_of(const Newest& newest) const;

  std::deque<One> all_;
  FrameTap tap_;  ///< writes all_, so declared after it
};

}  // namespace ovws
