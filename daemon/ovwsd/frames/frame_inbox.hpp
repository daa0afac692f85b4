/// The one frame that waits for a slow thread: copied out of the camera's buffer by the images
/// thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "core/base/image.hpp"
#include "core/tracking/spot.hpp"
#include "daemon/ovwsd/frames/frame_taker.hpp"

namespace ovws {

/// A frame with what was measured of it, owned.
struct FrameCopy {
  std::uint64_t frame_id = 0, hologram_id = 0;
  std::uint64_t plan_id = 0;  ///< of the plan that it was measured with
  std::int64_t t_arrival_ns = 0;
  int charge = 1;
  double gain_db = 0.0, gain_raw = kNotKnown;  ///< see CameraSettings
  double exposure_us = 0.0;
  bool valid = false;               ///< the coefficients are numbers
  std::vector<float> coefficients;  ///< minus the reference, in the order of the plan's modes
  std::vector<SpotFix> spots;
  std::vector<std::byte> pixels;
  ImageView image;  ///< of `pixels`
};

/// Settled, its settings known, and valid if the sensor has a reference.
bool can_be_refined(const FrameRecord& record);

/// Hands on the first usable frame that is measured after it was asked for.
class FrameInbox : public FrameTaker {
 public:
  using Usable = std::function<bool(const FrameRecord&)>;
  /// `usable` is asked in the images thread.
  explicit FrameInbox(Usable usable) : usable_(std::move(usable)) {}

  // The slow thread.
  /// Asks for a frame if none was asked for yet, and waits for it at most `timeout`; nullptr if
  /// none came. The frame is the caller's until the next call.
  const FrameCopy* next(std::chrono::milliseconds timeout);
  /// Nothing is asked for any more.
  void forget();

  bool wants() override;
  void take(const FrameRecord& record) override;

 private:
  enum class State { idle, asked, filled };
  const Usable usable_;
  std::mutex mutex_;
  std::condition_variable filled_;
  State state_ = State::idle;
  FrameCopy frame_;
};

}  // namespace ovws
