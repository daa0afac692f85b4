/// Templates of the tracker `fit`, and what they were rendered for.
#pragma once

#include <cstdint>
#include <memory>

#include "core/spots/frame_fit.hpp"

namespace ovws {

/// They stay right while the sensor's epoch and its reference stay: the wavefront may move away
/// from their operating point, and frames tell by how much.
struct ActiveTemplates {
  std::uint64_t sensor_epoch = 0;
  std::int64_t reference_taken_ns = 0;
  std::shared_ptr<const FrameFit> fit;
};

}  // namespace ovws
