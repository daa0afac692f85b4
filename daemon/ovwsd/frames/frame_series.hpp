/// Per-frame results of a series of frames, and the rules for which frames a measurement uses.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/pipeline/plan.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// Frames of one state of the sensor: its epoch and its hologram.
struct MeasuredUnder {
  std::uint64_t sensor_epoch = 0;
  std::uint64_t hologram_id = 0;

  /// Whether spots of this frame may be used: it was measured after the hologram had settled.
  bool settled(const FrameRecord& record) const { return record.settled && fits(record); }
  /// Whether pixels of this frame may be used: exposed after the hologram had settled, with known
  /// camera settings.
  bool still(const FrameRecord& record) const {
    return record.still && record.settings_known && fits(record);
  }

 private:
  bool fits(const FrameRecord& record) const {
    return record.plan->sensor_epoch == sensor_epoch && record.hologram_id == hologram_id;
  }
};

/// And of one tracker at one gain.
struct MeasuredWith {
  MeasuredUnder under;
  TrackerKind tracker = TrackerKind::lg;
  double gain_db = 0.0;  ///< as read back; see CameraSettings

  bool settled(const FrameRecord& record) const {
    return record.settings_known && same_number(record.gain_db, gain_db) &&
           record.plan->tracker_kind == tracker && under.settled(record);
  }
};

struct SeriesFrame {
  float saturated_fraction = 0.0F;  ///< of the spots
  std::vector<SpotFix> spots;       ///< one a subaperture
};

/// Where the positions of spots come from instead of the frames' own.
struct FromPixels {
  /// The centre of a window for each spot, whose centroid counts (see cell_centroid); empty: none.
  std::vector<Vec2> windows_px = {};
  /// Finds each spot again, from where it was found; null: none.
  std::shared_ptr<const SpotTracker> tracker = {};
  /// Where it starts for spots that the frame has lost, one a subaperture; empty: nowhere.
  std::vector<Vec2> starts_px = {};
};

/// Makes room for its frames when it is made: `add` does not allocate unless it needs pixels.
class FrameSeries {
 public:
  FrameSeries(int frames, int subapertures, FromPixels from = {});

  bool needs_pixels() const { return !from_.windows_px.empty() || from_.tracker; }
  /// False: it is full, or the frame has another number of spots, or of windows. Reads the pixels
  /// if it needs them.
  bool add(const FrameRecord& record);
  /// Those that were added. Call once.
  std::vector<SeriesFrame> take();

 private:
  std::vector<SeriesFrame> frames_;
  std::size_t count_ = 0, subapertures_;
  FromPixels from_;
  TrackScratch scratch_;
};

}  // namespace ovws
