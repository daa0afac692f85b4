/// Frame series: results of each frame, and the rules for which frames a measurement uses.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/pipeline/plan.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Sensor state that all frames of a measurement must share: sensor epoch and hologram.
struct MeasuredUnder {
  std::uint64_t sensor_epoch = 0;
  std::uint64_t hologram_id = 0;

  /// Whether the frame's spots may be used: it has this sensor state, and its hologram had settled.
  bool settled(const FrameRecord& record) const { return record.settled && fits(record); }
  /// Whether the frame's pixels may be used: it has this sensor state, was exposed after the
  /// hologram had settled, and its camera settings are known.
  bool still(const FrameRecord& record) const {
    return record.still && record.settings_known && fits(record);
  }

 private:
  bool fits(const FrameRecord& record) const {
    return record.plan->sensor_epoch == sensor_epoch && record.hologram_id == hologram_id;
  }
};

/// Sensor state, tracker and camera gain that all frames of a measurement must share.
struct MeasuredWith {
  MeasuredUnder under;
  TrackerKind tracker = TrackerKind::lg;
  double gain_db = 0.0;  ///< as read back from the camera; see CameraSettings

  bool settled(const FrameRecord& record) const {
    return record.settings_known && same_number(record.gain_db, gain_db) &&
           record.plan->tracker_kind == tracker && under.settled(record);
  }
};

struct SeriesFrame {
  float saturated_fraction = 0.0F;  ///< fraction of the spots that are saturated
  std::vector<SpotFix> spots;       ///< one per subaperture
};

/// Spot positions measured again from the pixels, to replace the positions in the frames.
struct FromPixels {
  /// Window centres, one per spot. The centroid in the window gives the spot's position (see
  /// cell_centroid). Empty: no windows.
  std::vector<Vec2> windows_px = {};
  /// Tracker that measures each spot again, starting at its found position; null: none.
  std::shared_ptr<const SpotTracker> tracker = {};
  /// Start positions of the tracker for lost spots, one per subaperture. Empty: lost spots stay
  /// lost.
  std::vector<Vec2> starts_px = {};
};

/// Series of measured frames. The constructor allocates the memory for all frames, so that `add`
/// does not allocate unless it needs pixels.
class FrameSeries {
 public:
  FrameSeries(int frames, int subapertures, FromPixels from = {});

  bool needs_pixels() const { return !from_.windows_px.empty() || from_.tracker; }
  /// Adds a frame, and reads its pixels if needs_pixels(). False: the series is full, or the number
  /// of spots in the frame or of windows differs from the number of subapertures.
  bool add(const FrameRecord& record);
  /// Moves out the frames that were added. Call once.
  std::vector<SeriesFrame> take();

 private:
  std::vector<SeriesFrame> frames_;
  std::size_t count_ = 0, subapertures_;
  FromPixels from_;
  TrackScratch scratch_;
};

}  // namespace ovws
