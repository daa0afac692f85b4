/// One frame at a time, copied out of the camera's buffer for a thread that needs seconds for it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/image.hpp"
#include "core/tracking/spot.hpp"
#include "daemon/ovwsd/frames/frame_broker.hpp"

namespace ovws {

/// A frame and what was measured in it, owned.
struct FrameCopy {
  std::uint64_t frame_id = 0, hologram_id = 0;
  std::uint64_t plan_id = 0;       ///< of the plan that measured it
  std::uint64_t sensor_epoch = 0;  ///< of that plan
  std::int64_t t_arrival_ns = 0;
  int charge = 1;
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  double exposure_us = 0.0;
  bool valid = false;               ///< the coefficients are numbers
  std::vector<float> coefficients;  ///< minus the reference, in the order of the plan's modes
  std::vector<SpotFix> spots;
  std::vector<std::byte> pixels;
  ImageView image;  ///< of `pixels`
};

/// A copy whose image is of its own pixels, unlike that of the copy constructor.
FrameCopy copy_of(const FrameCopy& frame);

/// Settled, its settings known, and valid if the sensor has a reference.
bool can_be_refined(const FrameRecord& record);

/// For the slow thread alone.
class FrameInbox {
 public:
  using Usable = std::function<bool(const FrameRecord&)>;
  /// `usable` decides whether a frame will do; the thread of the images calls it. The broker must
  /// outlive this object.
  FrameInbox(FrameBroker& broker, Usable usable) : broker_(broker), usable_(std::move(usable)) {}

  /// Requests a usable frame unless one is requested already, and waits for it, `timeout` at most;
  /// nullptr if none came. The frame is the caller's until the next call.
  const FrameCopy* next(std::chrono::milliseconds timeout);
  /// Withdraws the request, and drops a frame that came meanwhile.
  void forget() { request_.reset(); }

 private:
  FrameBroker& broker_;
  const Usable usable_;
  FrameCopy frame_;
  std::unique_ptr<FrameBroker::Request> request_;  ///< after frame_, which it fills
};

}  // namespace ovws
