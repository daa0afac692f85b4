#include "core/tracking/mixed_tracker.hpp"

#include <algorithm>
#include <utility>

#include "core/tracking/plane_tracker.hpp"

namespace ovws {
namespace {

std::vector<bool> present(const std::vector<std::shared_ptr<const TemplateBank>>& banks) {
  std::vector<bool> out;
  for (const auto& bank : banks) out.push_back(bank != nullptr);
  return out;
}

}  // namespace

MixedTracker::MixedTracker(std::unique_ptr<const SpotTracker> others, const SpotModel& spots,
                           std::vector<std::shared_ptr<const TemplateBank>> own)
    : others_(std::move(others)),
      has_own_(present(own)),
      matched_(
          on_plane(std::make_unique<MatchedTracker>(spots.on_plane(), std::move(own)), spots)) {}

int MixedTracker::window_half_px() const {
  return std::max(others_->window_half_px(), matched_->window_half_px());
}

TrackScratch MixedTracker::make_scratch() const {
  TrackScratch scratch = others_->make_scratch();
  const TrackScratch more = matched_->make_scratch();
  scratch.samples.resize(std::max(scratch.samples.size(), more.samples.size()));
  scratch.sums.resize(std::max(scratch.sums.size(), more.sums.size()));
  return scratch;
}

SpotFix MixedTracker::track(const ImageView& image, Vec2 start_px, TrackScratch& scratch,
                            int spot) const {
  const bool own = spot >= 0 && spot < int(has_own_.size()) && has_own_[std::size_t(spot)];
  return own ? matched_->track(image, start_px, scratch, spot)
             : others_->track(image, start_px, scratch, spot);
}

}  // namespace ovws
