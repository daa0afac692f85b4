/// Frame-to-frame tracking: start positions of the next frame from the last positions of the spots.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {

/// Last positions of the spots in settled frames, from which the next frame's tracking starts. One
/// thread at a time; only the constructor allocates.
///
/// Also judges whether spot positions can be trusted: after a sudden change, spots may be lost or
/// mistaken for each other. A frame *follows* if one of these is true:
/// - Templates describe it.
/// - The previous frame follows, and every spot of the reference is found, at most a quarter of
///   lambda/d from its last place. Templates may have described the frames since without that spot.
/// - The first templates are awaited, and every spot of the reference is found at most a quarter of
///   lambda/d from its reference position.
class SpotHistory {
 public:
  SpotHistory();

  /// Adapts the history to `plan`. Clears it and returns true if the plan measures other spots
  /// (sensor epoch, count or ROI) than the previous plan.
  bool fit_to(const MeasurementPlan& plan) OVWS_NONBLOCKING;

  /// Whether any spot has a history. False: a whole-image search is needed.
  bool live() const { return live_; }

  /// Start position of each spot in `record`: its last settled position, moved by the predicted
  /// shift if the hologram changed.
  void starts(const FrameRecord& record, std::span<SpotStart> starts) const OVWS_NONBLOCKING;

  /// Sets the history for a replay: the next record with `plan` starts from `starts`, under the
  /// plan's hologram. All NaN: no history.
  /// `follows`: whether the frame before that record followed.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts,
              bool follows) OVWS_NONBLOCKING;

  /// Whether the settled frame `record`, tracked from `starts()`, follows (see SpotHistory).
  bool is_followed_by(const FrameRecord& record) const OVWS_NONBLOCKING;

  /// Updates the history with the spots of a settled frame, and with its verdict `record.follows`.
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
  bool follows_ = false;  ///< whether the last frame followed
  std::uint64_t hologram_id_ = 0;
  std::uint64_t plan_id_ = 0;
  std::uint64_t sensor_epoch_ = 0;
  Roi roi_;
};

}  // namespace ovws
