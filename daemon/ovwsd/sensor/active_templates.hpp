/// Templates of the tracker `fit`, and what they were rendered for.
#pragma once

#include <cstdint>
#include <memory>

#include "core/spots/frame_fit.hpp"

namespace ovws {

/// They stay valid while the sensor's epoch, its reference and the active calibration stay the
/// same. The wavefront may move away from their operating point; frames show by how much.
struct ActiveTemplates {
  std::uint64_t sensor_epoch = 0;
  std::int64_t reference_taken_ns = 0;
  std::int64_t calibration_taken_ns = 0;  ///< 0: no measured templates are active
  std::shared_ptr<const FrameFit> fit;
  bool given_up = false;  ///< none are to come soon: positions count

  friend bool operator==(const ActiveTemplates&, const ActiveTemplates&) = default;
};

}  // namespace ovws
