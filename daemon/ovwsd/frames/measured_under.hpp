/// The rule for which frames a measurement uses.
#pragma once

#include <cstdint>
#include <optional>

#include "core/pipeline/frame_record.hpp"
#include "core/pipeline/plan.hpp"

namespace ovws {

/// What all frames of a measurement must share: sensor epoch, hologram, and the camera's exposure
/// and gain, if given.
struct MeasuredUnder {
  std::uint64_t sensor_epoch = 0;
  std::uint64_t hologram_id = 0;
  std::optional<CameraSettings> camera{};

  /// Whether the frame's spots may be used: it has this state, and its hologram had settled.
  bool settled(const FrameRecord& record) const { return record.settled && fits(record); }
  /// Whether the frame's pixels may be used: it has this state, was exposed after the hologram had
  /// settled, and its camera settings are known.
  bool still(const FrameRecord& record) const {
    return record.still && record.settings_known && fits(record);
  }

 private:
  bool fits(const FrameRecord& record) const {
    return record.plan->sensor_epoch == sensor_epoch && record.hologram_id == hologram_id &&
           (!camera || exposed_as(record, *camera));
  }
  static bool exposed_as(const FrameRecord& record, const CameraSettings& camera) {
    return record.settings_known && record.exposure_us == camera.exposure_us &&
           same_number(record.gain_db, camera.gain_db) &&
           same_number(record.gain_raw, camera.gain_raw);
  }
};

}  // namespace ovws
