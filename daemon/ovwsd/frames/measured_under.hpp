/// The rule for which frames a measurement uses.
#pragma once

#include <cstdint>

#include "core/pipeline/frame_record.hpp"
#include "core/pipeline/plan.hpp"

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

}  // namespace ovws
