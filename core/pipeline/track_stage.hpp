/// Second pipeline stage: measures modes and spots of one light source by templates. If they do not
/// describe the frame, finds every spot from its history, or by a search of the source's region.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/pipeline/back_off.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/pipeline/spot_history.hpp"
#include "core/rt/counters.hpp"
#include "core/rt/latency_histogram.hpp"

namespace ovws {

/// Tracking stage. For each frame in order, call `begin`, then every slice (in parallel), then
/// `finish`. The caller synchronises the calls between threads. Results do not depend on the number
/// of slices.
///
/// Whole-image search: runs for a frame without history or with more than a few spots lost, with
/// exponential backoff (BackOff) up to every 16th frame. A change of gain or exposure restarts the
/// backoff. The result is used only if it finds more spots.
///
/// Templates of a plan (MeasurementPlan::fit) are tried first. If they describe the frame
/// (FittedFrame::credible), they give its spots and modes, and no tracker runs.
class TrackStage {
 public:
  TrackStage(int slices, Counters& counters, LatencyHistogram& latency);

  void begin(Entry& entry) OVWS_NONBLOCKING;
  /// Tracks slice k = 0 .. slices-1 of the spots.
  void track_slice(Entry& entry, int k) OVWS_NONBLOCKING;
  /// Retries lost spots, searches if necessary, and updates the history.
  void finish(Entry& entry) OVWS_NONBLOCKING;

  /// For a replay: sets the history (SpotHistory::resume), and whether the next frame's whole image
  /// is searched.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts, bool follows,
              bool searched);

  /// Number of spots that may be lost without a whole-image search.
  static int few(int subapertures) { return subapertures / 8 > 2 ? subapertures / 8 : 2; }

 private:
  void watch_settings(const FrameStamp& frame) OVWS_NONBLOCKING;
  void track(Entry& entry, int begin, int end, TrackScratch& scratch) OVWS_NONBLOCKING;
  void fit(Entry& entry) OVWS_NONBLOCKING;
  void reject_implausible(Entry& entry) OVWS_NONBLOCKING;
  void retry_lost(Entry& entry) OVWS_NONBLOCKING;
  SpotFix retry(Entry& entry, int i, Vec2 expected_px) OVWS_NONBLOCKING;
  void search_if_needed(Entry& entry) OVWS_NONBLOCKING;
  void search(Entry& entry, int found) OVWS_NONBLOCKING;
  void summarise(Entry& entry) OVWS_NONBLOCKING;

  int slices_;
  Counters& counters_;
  LatencyHistogram& latency_;
  SpotHistory history_;
  BackOff search_back_off_;
  CameraSettings known_;  ///< gain and exposure of the last frame for which they were known
  std::optional<bool> forced_search_;  ///< overrides search_if_needed for the next frame
  std::vector<char> duplicate_;
  std::vector<SpotFix> searched_;
};

/// The tracking stages of all light sources and patterns; call them like one TrackStage. A frame of
/// a sequence whose pattern is uncertain is not tracked: all its spots are lost. `finish` releases
/// the frame's pixels.
class TrackStages {
 public:
  /// Largest numbers in a plan.
  struct Most {
    int beams = 0, patterns = 0;
  };
  /// `latency` counts the main source's measurements.
  TrackStages(Most most, int slices, Counters& counters, LatencyHistogram& latency);

  void begin(Entry& entry) OVWS_NONBLOCKING;
  void track_slice(Entry& entry, int k) OVWS_NONBLOCKING;
  void finish(Entry& entry) OVWS_NONBLOCKING;

  /// As Pipeline::resume.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts, bool follows,
              unsigned searched);

 private:
  TrackStage* main_of(const Entry& entry) OVWS_NONBLOCKING;

  std::vector<TrackStage> stages_;    ///< the main source's first
  std::vector<TrackStage> patterns_;  ///< of the main source, one for each pattern of a sequence
};

}  // namespace ovws
