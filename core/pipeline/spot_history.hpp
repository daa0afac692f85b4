/// Where the spots were last, and from that, where to look for them in the next frame.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/pipeline/frame_record.hpp"

namespace ovws {

/// Learns from settled frames only. One thread at a time; allocates in the constructor only.
class SpotHistory {
 public:
  SpotHistory();

  /// Forgets everything if `plan` measures other spots (sensor epoch, count or image size) than
  /// before, and returns true. Spots go to where a new search found them (search_px) if they were
  /// lost, or more than half of lambda/d from there.
  bool fit_to(const MeasurementPlan& plan) OVWS_NONBLOCKING;

  /// False: nothing is known of any spot, a whole-image search is needed.
  bool live() const { return live_; }

  /// Where to look for each spot in `record`: its last settled position, moved by what the plan
  /// predicts of a change of hologram.
  void starts(const FrameRecord& record, std::span<SpotStart> starts) const OVWS_NONBLOCKING;

  /// From now on as if the next record with `plan` were to be looked for at `starts`, under the
  /// hologram that the plan predicts for. NaN everywhere: nothing is known.
  void resume(const MeasurementPlan& plan, std::span<const SpotStart> starts) OVWS_NONBLOCKING;

  /// Takes over what was found in a settled frame.
  void learn(const FrameRecord& record) OVWS_NONBLOCKING;

 private:
  struct Track {
    SpotStart last;
    Vec2 expected_px;  ///< what the plan predicted for hologram_id_
  };

  void believe_search(const MeasurementPlan& plan) OVWS_NONBLOCKING;
  Vec2 moved(const Track& track, int i, const FrameRecord& record) const;

  std::vector<Track> tracks_;
  int count_ = 0;
  bool live_ = false;
  std::uint64_t hologram_id_ = 0;
  std::uint64_t plan_id_ = 0;
  std::uint64_t seen_plan_id_ = 0;
  Vec2 search_mark_;  ///< the first of the searched places that were taken over last
  std::uint64_t sensor_epoch_ = 0;
  Roi roi_;
};

}  // namespace ovws
