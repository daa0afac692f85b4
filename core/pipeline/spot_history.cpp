/// History is kept as positions under one hologram and what was expected under it.
#include "core/pipeline/spot_history.hpp"

#include <limits>

#include "core/optics/lattice.hpp"

namespace ovws {

SpotHistory::SpotHistory() : tracks_(kMaxSubapertures) {}

void SpotHistory::fit_to(const MeasurementPlan& plan) OVWS_NONBLOCKING {
  if (plan.sensor_epoch == sensor_epoch_ && plan.subapertures() == count_ &&
      plan.image_width == image_width_ && plan.image_height == image_height_) {
    return;
  }
  live_ = false;
  sensor_epoch_ = plan.sensor_epoch;
  count_ = plan.subapertures();
  image_width_ = plan.image_width;
  image_height_ = plan.image_height;
}

void SpotHistory::starts(const FrameRecord& record,
                         std::span<Vec2> starts_px) const OVWS_NONBLOCKING {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const bool same_hologram = record.hologram_id == hologram_id_;
  for (int i = 0; i < count_; ++i) {
    const Track& track = tracks_[i];
    if (!live_ || !track.found) {
      starts_px[i] = {kNone, kNone};
    } else if (same_hologram) {
      starts_px[i] = track.position_px;
    } else {
      starts_px[i] = track.position_px + (record.plan->predicted_px[i] - track.expected_px);
    }
  }
}

void SpotHistory::learn(const FrameRecord& record) OVWS_NONBLOCKING {
  const MeasurementPlan& plan = *record.plan;
  // With the hologram unchanged, a new plan may already predict for the next one: its predictions
  // count only once its hologram is seen.
  const bool plan_is_for_this = plan.hologram_id == record.hologram_id && plan.id != plan_id_;
  const bool expect_anew = !live_ || record.hologram_id != hologram_id_ || plan_is_for_this;
  live_ = false;
  for (int i = 0; i < count_; ++i) {
    Track& track = tracks_[i];
    const SpotFix& fix = record.spots[i];
    track.found = fix.found();
    if (expect_anew) track.expected_px = plan.predicted_px[i];
    if (!track.found) continue;
    track.position_px = {double(fix.x), double(fix.y)};
    live_ = true;
  }
  hologram_id_ = record.hologram_id;
  if (expect_anew) plan_id_ = plan.id;
}

}  // namespace ovws
