/// The second stage: finds every spot of a frame, from history or from a whole-image search.
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

/// For each frame in order: `begin`, then every slice (by any threads at once), then `finish`. The
/// caller orders these calls between threads; numbers do not depend on the number of slices.
///
/// A frame without history, or with more than a few spots lost, is searched whole, at most every
/// 16th frame while that does not help (BackOff). The search counts only if it finds more.
/// A plan with search_px says where spots are looked for that were lost, or are elsewhere
/// (SpotHistory).
class TrackStage {
 public:
  struct Config {
    int slices = 1;
  };
  struct Deps {
    Counters& counters;
    LatencyHistogram& latency;
  };

  TrackStage(const Config& config, const Deps& deps);

  void begin(Entry& entry) OVWS_NONBLOCKING;
  /// Slice k of 0 .. slices-1.
  void track_slice(Entry& entry, int k) OVWS_NONBLOCKING;
  /// Retries lost spots, searches if need be, keeps history. The frame's pixels are let go of.
  void finish(Entry& entry) OVWS_NONBLOCKING;

  /// See SpotHistory::resume; and the whole image is searched, or is not, as `searched` says.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts, bool searched);

  /// How many spots may be lost without a whole-image search.
  static int few(int subapertures) { return subapertures / 8 > 2 ? subapertures / 8 : 2; }

 private:
  void lose_incredible(Entry& entry) OVWS_NONBLOCKING;
  void retry_lost(Entry& entry) OVWS_NONBLOCKING;
  SpotFix retry(Entry& entry, int i, Vec2 expected_px) OVWS_NONBLOCKING;
  void search_if_needed(Entry& entry) OVWS_NONBLOCKING;
  void search(Entry& entry, int found) OVWS_NONBLOCKING;
  void summarise(Entry& entry) OVWS_NONBLOCKING;

  Config config_;
  Deps deps_;
  SpotHistory history_;
  BackOff search_back_off_;
  std::optional<bool> search_told_;  ///< for the next frame
  std::vector<char> doubled_;
  std::vector<SpotFix> searched_;
};

}  // namespace ovws
