/// The frame path: grab -> track -> reconstruct -> publish, as agents that the thread table runs.
#pragma once

#include <span>
#include <vector>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/port/camera.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/counters.hpp"
#include "core/rt/latency_histogram.hpp"
#include "core/rt/latest_value.hpp"

namespace ovws {

struct PipelineConfig {
  int workers = 0;   ///< tracker threads; 0: the acquisition agent runs all stages ("inline")
  int records = 64;  ///< maximum number of frames in flight, at least 4
  int beams = 0;     ///< largest number of further light sources in a plan (MeasurementPlan::beams)
  int patterns = 0;  ///< largest number of patterns in a plan (MeasurementPlan::patterns)
};

struct PipelineDeps {
  Counters& counters;
  LatestValue<ShownHologram>& shown;       ///< written by the display's thread
  LatestValue<AppliedSettings>& settings;  ///< written by the camera's thread
};

/// One histogram per stage; the status thread reads and resets them.
struct Latencies {
  LatencyHistogram arrived;  ///< delivery delay: from the undelayed arrival time (ArrivalClock) on
  LatencyHistogram tracked, reconstructed;  ///< from the frame's arrival to the end of the stage
};

/// Owns the stages, the records and the rings between them. Inline and threaded operation give
/// identical results.
class Pipeline {
 public:
  Pipeline(const PipelineConfig& config, const PipelineDeps& deps);

  // Agents, one thread each. tracker(k): k = 0 .. workers-1. With workers = 0 only acquisition()
  // does any work.
  Agent& acquisition();
  Agent& tracker(int k);
  Agent& reconstruction();

  // Control side; thread-safe among each other.
  /// Measures frames with `plan` from the next frame on; nullptr: frames are not measured. The
  /// caller keeps every plan alive until `oldest_plan_in_use` exceeds its id, and makes a
  /// hologram's plan active before the hologram has settled. May take milliseconds, because it
  /// allocates working memory.
  void use_plan(const MeasurementPlan* plan);
  /// Smallest plan id that the frame path or the publisher may still touch.
  std::uint64_t oldest_plan_in_use() const;
  /// Attaches a streaming camera to the acquisition agent, or detaches it. Each call returns when
  /// the agent no longer uses the previous camera and all its frames are released (bounded by the
  /// agent's wait of 20 ms and by the frames in flight). If the agent's thread does not run or an
  /// image is not released, the call fails after 2 s with Errc::unavailable, and the request
  /// remains. Destroy a camera only after a successful detach. Detach before the agents' threads
  /// end.
  Result<void> attach(Camera& camera);
  Result<void> detach();
  /// CLOCK_MONOTONIC ns of the last complete frame; 0: none since attach. Thread-safe.
  std::int64_t last_frame_mono_ns() const;
  /// CLOCK_MONOTONIC ns of the last frame of any kind, even incomplete; 0: none since attach.
  std::int64_t last_sign_mono_ns() const;

  // Publisher thread: the next finished record in frame order, or nullptr after `timeout_us`.
  // Return the record with release.
  FrameRecord* next(int timeout_us);
  void release(FrameRecord* record);

  // Image thread.
  /// Requests the pixels of one frame: the next measured frame's record keeps its image until
  /// release_image.
  void request_image();
  FrameRecord* next_image(int timeout_us);
  void release_image(FrameRecord* record);

  /// Any thread: starts recording with the next frame. Keeps every record, and the pixels of every
  /// n-th frame; 0: no pixels.
  void record(int pixels_every);
  void stop_recording();
  // Recording thread: the next recorded record in frame order, or nullptr after `timeout_us`.
  // Frames measured before stop_recording are still delivered. A slow recorder loses records, which
  // shows as gaps in `number`.
  FrameRecord* next_recorded(int timeout_us);
  /// Whether the record holds its pixels.
  static bool has_recorded_pixels(const FrameRecord& record);
  /// Returns a recorded record. Call it soon, because the record may hold a camera buffer.
  void release_recorded(FrameRecord* record);

  /// For a replay: sets the start positions of the next frame's spots, whether the frame before it
  /// `follows` (FrameRecord), and for which light sources the image is searched. `plan` is the
  /// active plan. `starts` has one element per subaperture of the main source, then those of each
  /// of `plan.beams`. Bit 0 of `searched` is the main source's, bit k that of the k-th further one.
  /// Call it only while no frame is in flight.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts, bool follows,
              unsigned searched);

  Latencies& latencies();

 private:
  struct Impl;
  Hidden<Impl> impl_;
};

}  // namespace ovws
