/// Frames as the camera would digitise them: the light of a scene through the detector's noise,
/// made ahead of time in one thread so that the camera only copies.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/optics/detector.hpp"
#include "drivers/twin/bench.hpp"

namespace ovws::twin {

/// What decides how a frame looks, apart from chance.
struct FrameRequest {
  std::shared_ptr<const Scene> scene;
  double exposure_us = 0.0;
  double gain_db = 0.0;
  PixelFormat format = PixelFormat::mono8;
  friend bool operator==(const FrameRequest&, const FrameRequest&) = default;
};

struct FrameCounts {
  std::uint64_t fresh = 0;  ///< realisations delivered for the first time
  std::uint64_t reused =
      0;  ///< with Noise::fresh: delivered again, because making them fell behind
};

/// Thread-safe; `take` is for one thread.
class FrameSource {
 public:
  /// `wavelength_nm`: of the laser, which a colour camera's filters pass or not.
  explicit FrameSource(double wavelength_nm) : wavelength_nm_(wavelength_nm) {}

  void work(const std::stop_token& stop);  ///< body of the noise thread

  /// Writes one frame, frame_bytes of them, into `out`. A frame never shows another
  /// request than this one: after a change the first ones are waited for. With Noise::fresh, once
  /// 16 different ones were delivered and no new one is ready, the one delivered longest ago is
  /// taken again. False on stop, or if there was none by the deadline.
  bool take(const FrameRequest& request, Bench::Deadline deadline, const std::stop_token& stop,
            std::span<std::byte> out);
  FrameCounts counts() const;

 private:
  using Frame = std::shared_ptr<const std::vector<std::byte>>;
  bool wants_more() const;  // call with mutex_ locked
  bool may_repeat() const;  // call with mutex_ locked
  Frame make(const FrameRequest& request);

  const double wavelength_nm_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<FrameRequest> request_;
  std::deque<Frame> ready_;  ///< made for request_, not delivered yet
  std::deque<Frame> past_;   ///< delivered for request_, the longest ago first
  FrameCounts counts_;

  // The noise thread only.
  std::optional<Detector> detector_;
  DetectorConfig detector_config_;
  Image<float> photons_;
  Image<std::uint16_t> dn_;
};

}  // namespace ovws::twin
