/// Validity watch: since when and why no frame has been valid, and what the daemon does about it.
#pragma once

#include <cstdint>
#include <optional>

#include "core/rt/seq_lock.hpp"
#include "core/wavefront/branch_points.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/frames/image_brightness.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// Without a settled frame for so long, nothing is known about the light.
constexpr std::int64_t kMaxFrameAgeNs = 1'500'000'000;
/// Frames must have been invalid for so long before an event says so.
constexpr std::int64_t kAnnounceNs = 500'000'000;

/// Progress of the wavefront search. Times are CLOCK_MONOTONIC.
struct SearchProgress {
  bool running = false;
  int searches = 0;          ///< failed searches since frames were last valid
  std::int64_t next_ns = 0;  ///< time of the next search, if the image does not change
};

/// Watches settled frames of a sensor with a reference. The publish thread calls `on_frame`. The
/// search thread calls `announce` and `search_*`. Any thread may call the other methods.
class ValidityWatch {
 public:
  /// Lack of valid frames: what is wrong with the newest invalid frame.
  struct Lack {
    std::int64_t since_ns = 0;  ///< start of the invalid period, CLOCK_MONOTONIC
    int tracked = 0, spots = 0;
    bool explained = true;  ///< false: no wavefront explains the spots' positions
    bool waits = false;     ///< true: templates must confirm the positions first
    bool searched = true;   ///< templates can measure frames, so the wavefront is searched
    /// See brightest_fraction; none: unknown.
    std::optional<double> brightest = std::nullopt;
    int branch_points = 0;          ///< recognised in the newest frame
    BranchPoint branch_point = {};  ///< the strongest of them
    bool no_pattern = false;        ///< of a sequence: no frame's pattern has been certain for long
    bool too_close = false;         ///< the spots are too close to those of another source
    bool undetermined = false;      ///< enough spots are found, but do not determine the modes
    bool enough_found = true;       ///< see enough_found of frame_rules.hpp
    double saturated = 0.0;         ///< fraction of the spots with a saturated pixel
  };

  /// `brightness`: of the camera's images; must outlive this object.
  explicit ValidityWatch(const ImageBrightness& brightness) : brightness_(brightness) {}

  void on_frame(bool valid, const Lack& lack, std::int64_t now_ns);

  /// Why frames are invalid. None if the newest frame was valid, or if no frame came for 1.5 s:
  /// missing frames have another cause, which is reported elsewhere.
  std::optional<Lack> lack(std::int64_t now_ns) const;
  /// Whether the newest frame was valid, or no frame has come yet.
  bool is_valid() const { return newest_.read().lack.since_ns == 0; }
  /// Describes the invalid period for the status message; none as for `lack`. `now_ns`
  /// (CLOCK_MONOTONIC) and `utc_ns` (UTC) are two clocks read at one moment.
  std::optional<StatusMessage::SensorPart::Invalid> why_invalid(std::int64_t now_ns,
                                                                std::int64_t utc_ns) const;

  void search_begins();
  void search_failed(std::int64_t next_ns);
  void search_succeeded() { progress_.set({}); }
  /// Publishes an event when no frame has been valid for half a second, and when frames are valid
  /// again.
  void announce(Events& events, std::int64_t now_ns);

 private:
  const ImageBrightness& brightness_;
  /// One frame's facts, which readers see together.
  struct Newest {
    Lack lack{};            ///< since_ns 0: the newest frame was valid
    std::int64_t t_ns = 0;  ///< CLOCK_MONOTONIC; 0: no frame yet
  };
  Newest written_;  ///< publish thread only: what it wrote last into newest_
  SeqLock<Newest> newest_;
  Guarded<SearchProgress> progress_;
  std::int64_t announced_ns_ = 0;  ///< start of the invalid period announced; 0: none is
};

/// Describes an invalid period for status and events. `now_ns` (CLOCK_MONOTONIC) and `utc_ns` (UTC)
/// are two clocks read at one moment.
StatusMessage::SensorPart::Invalid invalid_in_words(const ValidityWatch::Lack& lack,
                                                    const SearchProgress& search,
                                                    std::int64_t now_ns, std::int64_t utc_ns);

}  // namespace ovws
