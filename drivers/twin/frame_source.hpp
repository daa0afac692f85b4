/// Generator of digitised frames: applies the detector model with noise to a scene's intensity. One
/// thread prepares frames in advance, so that the camera's thread only copies them.
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

/// Inputs of a frame: all that determines its pixels except the noise.
struct FrameRequest {
  std::shared_ptr<const Scene> scene;
  Exposed exposed;
  double exposure_us = 0.0;
  double gain_db = 0.0;
  PixelFormat format = PixelFormat::mono8;
  friend bool operator==(const FrameRequest&, const FrameRequest&) = default;
};

struct FrameCounts {
  std::uint64_t fresh = 0;   ///< noise realisations delivered for the first time
  std::uint64_t reused = 0;  ///< Noise::fresh: old frames repeated because generation fell behind
};

/// Source of the camera's frames. Keeps a pool of frames for each request that differs from the
/// newest one in `exposed` only: in pattern mode one for each pattern. Thread-safe, but only one
/// thread may call `take`.
class FrameSource {
 public:
  /// `wavelength_nm`: laser wavelength, which a colour camera's filters attenuate or pass.
  explicit FrameSource(double wavelength_nm) : wavelength_nm_(wavelength_nm) {}

  void work(const std::stop_token& stop);  ///< body of the noise thread

  /// Copies one frame of this request into `out`, whose size must be frame_bytes(). For a new
  /// request this waits for the first new frame. With Noise::fresh, if no new frame is ready and 16
  /// frames were delivered, it repeats the oldest of them; less than 16 where the pools would take
  /// more than 512 MiB. False on stop, at the deadline,
  /// or if `out` has the wrong size.
  bool take(const FrameRequest& request, Bench::Deadline deadline, const std::stop_token& stop,
            std::span<std::byte> out);
  FrameCounts counts() const;

 private:
  using Frame = std::shared_ptr<const std::vector<std::byte>>;
  struct Pool {
    FrameRequest request;
    std::uint64_t takes = 0;  ///< how often the request was taken
    std::deque<Frame> ready;  ///< generated, not delivered yet
    std::deque<Frame> past;   ///< delivered, oldest first
  };
  // Call these with mutex_ locked.
  Pool* find(const FrameRequest& request);
  Pool& find_or_add(const FrameRequest& request);
  std::size_t history_of(const Pool& pool) const;
  bool wants_more(const Pool& pool) const;
  const Pool* wanting() const;

  Frame make(const FrameRequest& request);

  const double wavelength_nm_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<Pool> pools_;        ///< of one scene, exposure, gain and format
  const Pool* newest_ = nullptr;  ///< of the newest request
  FrameCounts counts_;

  // Used by the noise thread (`work`) only.
  std::optional<Detector> detector_;
  DetectorConfig detector_config_;
  Image<float> photons_;
  Image<std::uint16_t> dn_;
};

}  // namespace ovws::twin
