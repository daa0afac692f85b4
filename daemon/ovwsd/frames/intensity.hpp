/// Mean intensity at two places of the image, frame by frame, settled or not.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "daemon/ovwsd/frames/frame_broker.hpp"

namespace ovws {

struct IntensityFrame {
  std::int64_t t_device_ns = 0;
  std::int64_t t_arrival_mono_ns = 0;
  double exposure_us = 0.0;
  std::array<double, 2> mean_dn{};  ///< of the pixels around each place
};

/// Records from its first moment to `end`, 100,000 frames at most. For one thread.
class IntensityWatch {
 public:
  /// Averages the square of half-width `radius_px` about each place. The broker outlives this
  /// object.
  IntensityWatch(FrameBroker& broker, std::array<Vec2, 2> places_px, double radius_px);
  IntensityWatch(const IntensityWatch&) = delete;
  IntensityWatch& operator=(const IntensityWatch&) = delete;

  int count() const { return request_->used(); }
  /// Seconds since the last frame.
  double idle_s() const { return request_->idle_s(); }
  /// What was recorded, and no more. Call once.
  std::vector<IntensityFrame> end();

 private:
  std::vector<IntensityFrame> frames_;
  std::unique_ptr<FrameBroker::Request> request_;  ///< after frames_, which it fills
};

}  // namespace ovws
