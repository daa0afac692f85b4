/// Which frames a measurement uses.
#pragma once

#include <cstdint>

#include "core/pipeline/frame_record.hpp"
#include "core/pipeline/plan.hpp"

namespace ovws {

/// Frames of one state of the sensor: its epoch and its hologram.
struct MeasuredUnder {
  std::uint64_t sensor_epoch = 0;
  std::uint64_t hologram_id = 0;

  /// Measured after the hologram had settled: for spots.
  bool settled(const FrameRecord& record) const { return record.settled && fits(record); }
  /// Exposed after the hologram had settled, with known settings: for images.
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

}  // namespace ovws
