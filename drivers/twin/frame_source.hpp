/// Generator of digitised frames: applies the detector model with noise to a scene's intensity. One
/// thread works ahead, so that the camera only copies.
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

/// All that determines a frame except the noise.
struct FrameRequest {
  std::shared_ptr<const Scene> scene;
  double exposure_us = 0.0;
  double gain_db = 0.0;
  PixelFormat format = PixelFormat::mono8;
  friend bool operator==(const FrameRequest&, const FrameRequest&) = default;
};

struct FrameCounts {
  std::uint64_t fresh = 0;   ///< noise realisations delivered for the first time
  std::uint64_t reused = 0;  ///< with Noise::fresh: delivered again because generation fell behind
};

/// Thread-safe; `take` is for one thread.
class FrameSource {
 public:
  /// `wavelength_nm`: of the laser, for a colour camera's filters.
  explicit FrameSource(double wavelength_nm) : wavelength_nm_(wavelength_nm) {}

  void work(const std::stop_token& stop);  ///< body of the noise thread

  /// Writes one frame of this request (frame_bytes) into `out`. After a change of the request it
  /// waits for the first new frame. With Noise::fresh, once 16 different frames were delivered and
  /// no new one is ready, the one delivered longest ago is used again. False on stop, at the
  /// deadline, or if `out` has another size.
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
  std::deque<Frame> ready_;  ///< generated for request_, not delivered yet
  std::deque<Frame> past_;   ///< delivered for request_, oldest first
  FrameCounts counts_;

  // The noise thread only.
  std::optional<Detector> detector_;
  DetectorConfig detector_config_;
  Image<float> photons_;
  Image<std::uint16_t> dn_;
};

}  // namespace ovws::twin
