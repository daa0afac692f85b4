/// Spot templates of the tracker `fit`, and the sensor state that they were rendered for.
#pragma once

#include <cstdint>
#include <memory>

#include "core/spots/frame_fit.hpp"

namespace ovws {

/// Templates are valid until the sensor's epoch, the reference or the active calibration changes.
/// The wavefront may drift away from their operating point: every frame reports the drift.
struct ActiveTemplates {
  std::uint64_t sensor_epoch = 0;
  std::int64_t reference_taken_ns = 0;
  std::int64_t calibration_taken_ns = 0;  ///< 0: no measured templates are active
  std::shared_ptr<const FrameFit> fit;
  bool given_up = false;  ///< no templates will come soon: use spot positions instead

  friend bool operator==(const ActiveTemplates&, const ActiveTemplates&) = default;
};

}  // namespace ovws
