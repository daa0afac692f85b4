/// Frame-to-frame tracking: start positions of the next frame from the last positions of the spots.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {

/// Uses settled frames only. One thread at a time; only the constructor allocates.
///
/// It also judges whether positions can be trusted: a frame *follows* if templates describe it, or
/// if every spot of the reference stands within lambda/d / 4 of its start, and the previous frame
/// follows. While the first templates are awaited, it also follows if every spot stands as close to
/// its place in the reference. After a sudden change spots may be lost or mistaken for each other.
class SpotHistory {
 public:
  SpotHistory();

  /// Adapts to `plan`. Clears the history and returns true if the plan measures other spots (sensor
  /// epoch, count or ROI) than the previous one.
  bool fit_to(const MeasurementPlan& plan) OVWS_NONBLOCKING;

  /// False: no spot has a history, a whole-image search is needed.
  bool live() const { return live_; }

  /// Start position of each spot in `record`: its last settled position, moved by the predicted
  /// shift if the hologram changed.
  void starts(const FrameRecord& record, std::span<SpotStart> starts) const OVWS_NONBLOCKING;

  /// Sets the history for a replay: the next record with `plan` starts from `starts`, under the
  /// plan's hologram. All NaN: no history.
  /// `follows`: the frame before that record.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts,
              bool follows) OVWS_NONBLOCKING;

  /// Whether a settled frame with the starts of `starts()` follows.
  bool is_followed_by(const FrameRecord& record) const OVWS_NONBLOCKING;

  /// Updates the history with the spots of a settled frame, and with `record.follows`.
  void learn(const FrameRecord& record) OVWS_NONBLOCKING;

 private:
  struct Track {
    SpotStart last;
    Vec2 expected_px;  ///< the plan's prediction for hologram_id_
  };

  Vec2 moved(const Track& track, int i, const FrameRecord& record) const;

  std::vector<Track> tracks_;
  int count_ = 0;
  bool live_ = false;
  bool follows_ = false;  ///< the last frame
  std::uint64_t hologram_id_ = 0;
  std::uint64_t plan_id_ = 0;
  std::uint64_t sensor_epoch_ = 0;
  Roi roi_;
};

}  // namespace ovws
