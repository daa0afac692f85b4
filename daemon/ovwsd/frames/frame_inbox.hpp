/// Frame inbox: copies one frame at a time out of the camera's buffer, for a thread that works on a
/// frame for up to seconds.
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

/// Frame copy: pixels and measured values of a frame, independent of the camera's buffer.
struct FrameCopy {
  std::uint64_t frame_id = 0, hologram_id = 0;
  std::uint64_t plan_id = 0;       ///< the measurement plan that measured the frame
  std::uint64_t sensor_epoch = 0;  ///< sensor epoch of the measurement plan
  std::int64_t t_arrival_ns = 0;
  int charge = 1;
  double gain_db = 0.0, gain_raw = kUnknownGain;  ///< see CameraSettings
  double exposure_us = 0.0;
  bool valid = false;               ///< true: all coefficients are numbers
  std::vector<float> coefficients;  ///< waves, minus the reference, in order of the plan's modes
  std::vector<SpotFix> spots;
  std::vector<std::byte> pixels;
  ImageView image;  ///< view of `pixels`
};

/// Deep copy of a frame: its image views its own pixels. With the copy constructor, the image would
/// view the pixels of the original.
FrameCopy copy_of(const FrameCopy& frame);

/// Whether a frame can be refined: its hologram had settled, its camera settings are known, and it
/// is valid or the sensor has no reference.
bool can_be_refined(const FrameRecord& record);

/// Frame inbox of one slow thread. Only this thread may call its methods.
class FrameInbox {
 public:
  using Usable = std::function<bool(const FrameRecord&)>;
  /// `usable` decides whether a frame is used; the images thread calls it. The broker must outlive
  /// this object.
  FrameInbox(FrameBroker& broker, Usable usable) : broker_(broker), usable_(std::move(usable)) {}

  /// Requests a usable frame and waits for it, for `timeout` at most; nullptr if none came. The
  /// request then stays open for the next call. The frame stays unchanged until the next call.
  const FrameCopy* next(std::chrono::milliseconds timeout);
  /// Withdraws the request, and drops a frame that has already arrived.
  void forget() { request_.reset(); }

 private:
  FrameBroker& broker_;
  const Usable usable_;
  FrameCopy frame_;
  std::unique_ptr<FrameBroker::Request> request_;  ///< fills frame_, so declared after it
};

}  // namespace ovws
