/// Which frames show what a sensor shows.
#pragma once

#include <cstdint>

#include "core/pipeline/frame_record.hpp"
#include "core/pipeline/plan.hpp"

namespace ovws {

/// Frames of one state of the sensor: its epoch and its hologram.
struct MeasuredUnder {
  std::uint64_t sensor_epoch = 0;
  std::uint64_t hologram_id = 0;

  bool operator()(const FrameRecord& record) const {
    return record.plan->sensor_epoch == sensor_epoch && record.hologram_id == hologram_id;
  }
};

}  // namespace ovws
