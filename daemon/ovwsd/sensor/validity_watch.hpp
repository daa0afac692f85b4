/// Validity watch: since when and why no frame of a light source has been valid, and what the
/// daemon does about it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/config.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/rt/seq_lock.hpp"
#include "daemon/ovwsd/actor/events.hpp"
#include "daemon/ovwsd/frames/image_brightness.hpp"
#include "daemon/shared/guarded.hpp"
#include "proto/status_message.hpp"

namespace ovws {

/// Progress of the wavefront search. Times are CLOCK_MONOTONIC.
struct SearchProgress {
  bool running = false;
  int searches = 0;          ///< failed searches since frames were last valid
  std::int64_t next_ns = 0;  ///< time of the next search, if the image does not change
};

/// What is known of the newest frame of a light source.
struct Lack {
  Verdict verdict = Verdict::valid;
  int tracked = 0, spots = 0;
  bool searched = false;               ///< the wavefront of such frames is searched
  bool enough_found = true;            ///< see enough_found of frame_rules.hpp
  double saturated = 0.0;              ///< fraction of the spots with a saturated pixel
  int branch_points = 0;               ///< recognised in the frame
  BranchPoint branch_point = {};       ///< the strongest of them
  const std::string* other = nullptr;  ///< label of the source that is too close
  std::int64_t since_ns = 0;           ///< start of the invalid period, CLOCK_MONOTONIC
  std::int64_t t_ns = 0;               ///< when it was noted, CLOCK_MONOTONIC; 0: no frame yet
};

/// Watches the settled frames of all light sources whose sensor has a reference. The publish thread
/// calls `on_frame`, the search thread `announce` and `search_*`. Any thread may call the others.
/// Source 0 is the main one, source k the k-th further one.
class ValidityWatch {
 public:
  /// `brightness`: of the camera's images; must outlive this object.
  ValidityWatch(const std::vector<BeamConfig>& beams, const ImageBrightness& brightness);

  /// Call for every frame. `searched`: templates can measure such frames, so their wavefront is
  /// searched. RT-safe.
  void on_frame(const FrameRecord& main, bool searched, std::int64_t now_ns) OVWS_NONBLOCKING;
  /// Notes the newest frame of a source; since_ns and t_ns follow from `now_ns`. RT-safe.
  void note(std::size_t source, Lack newest, std::int64_t now_ns) OVWS_NONBLOCKING;

  /// None if the newest frame was valid, or if no frame came for 1.5 s: missing frames have another
  /// cause, which is reported elsewhere.
  std::optional<Lack> lack(std::size_t source, std::int64_t now_ns) const;
  /// Whether the newest frame was valid, or no frame has come yet.
  bool is_valid(std::size_t source) const { return sources_[source].newest.read().since_ns == 0; }
  /// Describes the invalid period for the status message; none as for `lack`. `now_ns`
  /// (CLOCK_MONOTONIC) and `utc_ns` (UTC) are two clocks read at one moment.
  std::optional<StatusMessage::SensorPart::Invalid> why_invalid(std::size_t source,
                                                                std::int64_t now_ns,
                                                                std::int64_t utc_ns) const;

  void search_begins();
  void search_failed(std::int64_t next_ns);
  void search_succeeded() { progress_.set({}); }
  /// Publishes an event when no frame of a source has been valid for half a second, and when frames
  /// are valid again.
  void announce(Events& events, std::int64_t now_ns);

 private:
  struct Source {
    Source() : label("the main source") {}
    explicit Source(const BeamConfig& beam) : name(beam.name), label("the source " + beam.name) {}
    const std::string name;  ///< empty: the main one
    const std::string label;
    SeqLock<Lack> newest;           ///< one frame's facts, which readers see together
    std::int64_t announced_ns = 0;  ///< start of the invalid period announced; 0: none is
  };
  const std::string* too_close_to(const FrameRecord& main, std::size_t source) const;
  void announce(std::size_t source, Events& events, std::int64_t now_ns);

  const ImageBrightness& brightness_;
  std::deque<Source> sources_;
  Guarded<SearchProgress> progress_;  ///< of the main source's wavefront
  int uncertain_ = 0;  ///< frames of a sequence without a certain pattern; publish thread only
};

/// Reason and action as one text.
std::string in_words(const StatusMessage::SensorPart::Invalid& why);

}  // namespace ovws
