/// Spot tracks: the last position of each spot, and the prediction for the hologram shown then.
#include "core/pipeline/spot_history.hpp"

#include <cmath>
#include <limits>

#include "core/optics/lattice.hpp"

namespace ovws {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kMaxStep = 0.25;  // largest distance from start or reference, lambda/d
constexpr SpotStart kUnknown{{kNone, kNone}, false};

}  // namespace

SpotHistory::SpotHistory() : tracks_(kMaxSubapertures) {}

bool SpotHistory::fit_to(const MeasurementPlan& plan) OVWS_NONBLOCKING {
  const bool same =
      plan.sensor_epoch == sensor_epoch_ && plan.subapertures() == count_ && plan.roi == roi_;
  if (!same) {
    live_ = false;
    follows_ = false;
    sensor_epoch_ = plan.sensor_epoch;
    count_ = plan.subapertures();
    roi_ = plan.roi;
  }
  return !same;
}

Vec2 SpotHistory::moved(const Track& track, int i, const FrameRecord& record) const {
  if (record.hologram_id == hologram_id_) return track.last.at_px;
  return track.last.at_px + (record.plan->predicted_px[i] - track.expected_px);
}

void SpotHistory::starts(const FrameRecord& record,
                         std::span<SpotStart> starts) const OVWS_NONBLOCKING {
  for (int i = 0; i < count_; ++i) {
    const Track& track = tracks_[i];
    starts[i] = live_ ? SpotStart{moved(track, i, record), track.last.fresh} : kUnknown;
  }
}

void SpotHistory::resume(const MeasurementPlan& plan, std::span<const SpotStart> starts,
                         bool follows) OVWS_NONBLOCKING {
  fit_to(plan);
  follows_ = follows;
  live_ = false;
  hologram_id_ = plan.hologram_id;
  plan_id_ = plan.id;
  for (int i = 0; i < count_; ++i) {
    tracks_[i] = {starts[i], plan.predicted_px[i]};
    live_ = live_ || !std::isnan(starts[i].at_px.x);
  }
}

namespace {

/// Whether every spot is near its reference position, so that no spot is mistaken for another.
bool is_at_reference(const FrameRecord& record) OVWS_NONBLOCKING {
  const MeasurementPlan& plan = *record.plan;
  for (std::size_t i = 0; i < plan.reference_px.size(); ++i) {
    if (std::isnan(plan.reference_px[i].x)) continue;
    const SpotFix& fix = record.spots[i];
    const Vec2 moved = Vec2{double(fix.x), double(fix.y)} - plan.reference_px[i];
    if (!fix.found() || !(norm(moved) <= kMaxStep * plan.spots.lambda_d_px)) return false;
  }
  return true;
}

}  // namespace

bool SpotHistory::is_followed_by(const FrameRecord& record) const OVWS_NONBLOCKING {
  if (record.templates.credible) return true;
  const MeasurementPlan& plan = *record.plan;
  if (!plan.referenced()) return false;
  if (plan.awaits_templates && is_at_reference(record)) return true;
  if (!follows_) return false;
  for (int i = 0; i < count_; ++i) {
    const SpotFix& fix = record.spots[i];
    const SpotStart& start = record.starts[i];
    if (std::isnan(plan.reference_px[std::size_t(i)].x)) continue;
    if (!fix.found()) return false;
    const Vec2 step = Vec2{double(fix.x), double(fix.y)} - start.at_px;
    if (!(norm(step) <= kMaxStep * plan.spots.lambda_d_px)) return false;
  }
  return true;
}

void SpotHistory::learn(const FrameRecord& record) OVWS_NONBLOCKING {
  const MeasurementPlan& plan = *record.plan;
  // A new plan may predict for the next hologram while the old hologram is still shown. Use its
  // predictions only once a frame shows the plan's hologram.
  const bool plan_is_for_this = plan.hologram_id == record.hologram_id && plan.id != plan_id_;
  const bool new_prediction = !live_ || record.hologram_id != hologram_id_ || plan_is_for_this;
  const bool was_live = live_;
  follows_ = record.follows;
  live_ = false;
  for (int i = 0; i < count_; ++i) {
    Track& track = tracks_[i];
    const SpotFix& fix = record.spots[i];
    if (fix.found()) {
      track.last = {{double(fix.x), double(fix.y)}, true};
      live_ = true;
    } else {
      track.last = was_live ? SpotStart{moved(track, i, record), false} : kUnknown;
    }
    if (new_prediction) track.expected_px = plan.predicted_px[i];
  }
  hologram_id_ = record.hologram_id;
  if (new_prediction) plan_id_ = plan.id;
}

}  // namespace ovws
