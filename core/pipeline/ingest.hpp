/// First pipeline stage: grabs frames and stamps each one with its settings and hologram.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "core/base/realtime.hpp"
#include "core/pipeline/arrival_clock.hpp"
#include "core/pipeline/camera_exchange.hpp"
#include "core/pipeline/frame_rules.hpp"
#include "core/pipeline/msb_alignment.hpp"
#include "core/pipeline/pattern_follower.hpp"
#include "core/pipeline/pipeline.hpp"
#include "core/pipeline/plan_exchange.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/pipeline/record_tap.hpp"

namespace ovws {

/// Frame grabbing. All methods are for the acquisition thread, unless stated otherwise.
class Ingest {
 public:
  struct Deps {
    Counters& counters;
    LatestValue<ShownHologram>& shown;
    LatestValue<AppliedSettings>& settings;
    CameraExchange& cameras;
    PlanExchange& plans;
    RecordPool& pool;
    RecordTap& tap;
    LatencyHistogram& arrived;  ///< delivery delay (ArrivalClock), only for cameras with timestamps
  };

  explicit Ingest(const Deps& deps) : deps_(deps) {}

  /// One iteration: returns buffers, serves camera requests, waits at most 20 ms for a frame.
  /// Returns a record to measure, or nullptr. Sets `idle` if no frame of any kind came.
  Entry* run_once(bool& idle);

  /// Returns unused buffers to the camera, and unused records to the pool.
  void return_buffers() OVWS_NONBLOCKING;

  /// Any thread: requests the pixels of the next measured frame for the image thread.
  void request_image() { image_requested_.store(true, std::memory_order_relaxed); }
  /// Any thread: time of the last complete frame, and of the last frame of any kind; 0: none yet.
  std::int64_t last_frame_mono_ns() const {
    return last_frame_mono_ns_.load(std::memory_order_relaxed);
  }
  std::int64_t last_sign_mono_ns() const {
    return last_sign_mono_ns_.load(std::memory_order_relaxed);
  }

 private:
  bool serve_camera() OVWS_NONBLOCKING;
  Entry* reject(Counter why) OVWS_NONBLOCKING;
  bool is_next(std::uint64_t frame_id) OVWS_NONBLOCKING;
  Entry* accept(GrabbedFrame& frame) OVWS_NONBLOCKING;
  void align_pixels(GrabbedFrame& frame) OVWS_NONBLOCKING;
  Entry* take_entry(const GrabbedFrame& frame) OVWS_NONBLOCKING;
  void count_lost(std::uint64_t frame_id) OVWS_NONBLOCKING;
  void stamp(Entry& entry) OVWS_NONBLOCKING;
  void assign_pattern(Entry& entry, const HologramVerdict& hologram) OVWS_NONBLOCKING;

  Deps deps_;
  std::uint64_t stream_ = 0;
  bool any_frame_ = false;
  std::uint64_t last_frame_id_ = 0;
  std::uint64_t incomplete_since_ = 0;
  ArrivalClock arrivals_;
  MsbAlignmentDetector msb_alignment_;
  PatternFollower patterns_;
  std::uint64_t patterns_hologram_id_ = 0;  ///< whose patterns patterns_ follows
  double last_exposure_us_ = 0.0;
  std::atomic<bool> image_requested_{false};
  std::atomic<std::int64_t> last_frame_mono_ns_{0};
  std::atomic<std::int64_t> last_sign_mono_ns_{0};
};

}  // namespace ovws
