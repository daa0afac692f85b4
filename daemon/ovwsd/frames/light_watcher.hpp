/// How the light at two places of the camera goes from frame to frame, settled or not.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <vector>

#include "core/base/vec2.hpp"
#include "daemon/ovwsd/frames/frame_taker.hpp"

namespace ovws {

/// `begin` and `end` from any thread.
class LightWatcher : public FrameTaker {
 public:
  struct Seen {
    std::int64_t t_device_ns = 0;
    std::int64_t t_arrival_mono_ns = 0;
    double exposure_us = 0.0;
    std::array<double, 2> light_dn{};  ///< mean of each place's pixels
  };

  /// From now on every frame that comes; the light within `radius_px` of each place.
  void begin(std::array<Vec2, 2> places_px, double radius_px);
  std::size_t count();  ///< frames seen so far
  /// What was seen since, and no more.
  std::vector<Seen> end();

  bool wants() override;
  void take(const FrameRecord& record) override;

 private:
  static constexpr std::size_t kMost = 100'000;
  std::mutex mutex_;
  bool watching_ = false;
  std::array<Vec2, 2> places_px_;
  double radius_px_ = 0.0;
  std::vector<Seen> seen_;
};

}  // namespace ovws
