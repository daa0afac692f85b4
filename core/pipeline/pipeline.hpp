/// The frame path: grab -> track -> reconstruct -> out, as agents that the thread table runs.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/port/camera.hpp"
#include "core/rt/agent.hpp"
#include "core/rt/counters.hpp"
#include "core/rt/latency_histogram.hpp"
#include "core/rt/latest_value.hpp"

namespace ovws {

struct PipelineConfig {
  int workers = 0;   ///< tracker threads; 0: all stages run inside the acquisition agent ("inline")
  int records = 64;  ///< frames that may be on their way at once, at least 4
};

struct PipelineDeps {
  Counters& counters;
  LatestValue<ShownHologram>& shown;       ///< written by the display's thread
  LatestValue<AppliedSettings>& settings;  ///< written by the camera's thread
};

/// Owns the stages, the records and the rings between them. Inline and threaded give identical
/// numbers.
class Pipeline {
 public:
  Pipeline(const PipelineConfig& config, const PipelineDeps& deps);
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  // Agents, one thread each. tracker(k): k = 0 .. workers-1. With workers = 0 only acquisition()
  // has work.
  Agent& acquisition();
  Agent& tracker(int k);
  Agent& reconstruction();

  // Control side; thread-safe among each other.
  /// From the next frame edge on, frames are measured with `plan`; nullptr: with none. The caller
  /// keeps every plan alive until `oldest_plan_in_use` has passed its id. By the time a
  /// hologram has settled, its plan is to be in use. May take milliseconds: working memory is made
  /// here.
  void use_plan(const MeasurementPlan* plan);
  /// Smallest plan id that the frame path or the publisher may still touch.
  std::uint64_t oldest_plan_in_use() const;
  /// Gives the acquisition agent a camera that streams, or takes it away: returns when the agent
  /// has let go of the camera before and all its frames were released (bounded by the agent's wait,
  /// 20 ms, and by the frames on their way). While nobody turns the agent, or somebody keeps an
  /// image, they give up after 2 s with Errc::unavailable: the request stands, and only a detach
  /// that succeeds says that a camera may be destroyed. Detach before the agents' threads end.
  Result<void> attach(Camera& camera);
  Result<void> detach();
  /// CLOCK_MONOTONIC ns of the last complete frame; 0: none since attach. Thread-safe.
  std::int64_t last_frame_mono_ns() const;
  /// The same of any frame, incomplete ones too.
  std::int64_t last_sign_mono_ns() const;

  // Publisher thread: the next finished record, in frame order, or nullptr after `timeout_us`; give
  // it back with release.
  FrameRecord* next(int timeout_us);
  void release(FrameRecord* record);

  /// Asks for one more frame's pixels: the next measured frame's record keeps its image lent until
  /// release_image.
  // Image thread.
  void request_image();
  FrameRecord* next_image(int timeout_us);
  void release_image(FrameRecord* record);

  /// Every record from the next frame on, with the pixels of every n-th; 0: of none. Any thread.
  void record(int pixels_every);
  void stop_recording();
  // Recording thread: the next of them, in frame order, or nullptr after `timeout_us`; those that
  // were measured before stop_recording still come. Who is behind misses some: `number` tells.
  FrameRecord* next_recorded(int timeout_us);
  /// Whether the record's pixels are lent with it.
  static bool has_recorded_pixels(const FrameRecord& record);
  /// Soon: a buffer of the camera may wait.
  void release_recorded(FrameRecord* record);

  /// For a replay, while no frame is under way: as if the spots of the next frame were looked for
  /// there, and the whole image searched or not. `plan` is the one in use, and `starts` are as many
  /// as its subapertures.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts, bool searched);

  // One histogram a stage; read and reset by the status thread.
  /// The frame's arrival, since it could have arrived had nothing held it up (ArrivalClock).
  LatencyHistogram& arrived_latency();
  /// Since the frame's arrival.
  LatencyHistogram& tracked_latency();
  LatencyHistogram& reconstructed_latency();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
