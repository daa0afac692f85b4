#include "core/tracking/matched.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/tracking/matched_fit.hpp"
#include "core/tracking/patch.hpp"
#include "core/tracking/spot_geometry.hpp"

namespace ovws {
namespace {

constexpr double kCapture = 1.0;                     // lambda/d
constexpr double kSearch = 0.8, kSearchStep = 0.26;  // lambda/d

/// Whether the image holds every pixel within `margin` of `at`.
bool holds(const ImageView& image, Vec2 at, double margin) {
  return at.x - margin >= 0.0 && at.y - margin >= 0.0 && at.x + margin <= image.width - 1.0 &&
         at.y + margin <= image.height - 1.0;
}

std::vector<Vec2> search_shifts(double lambda_d_px) {
  const int reach = int(std::lround(kSearch / kSearchStep));
  std::vector<Vec2> shifts;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (x * x + y * y > reach * reach) continue;
      shifts.push_back(kSearchStep * lambda_d_px * Vec2{double(x), double(y)});
    }
  }
  return shifts;
}

}  // namespace

MatchedTracker::MatchedTracker(const SpotModel& spots) : MatchedTracker(spots, {}) {}

MatchedTracker::MatchedTracker(const SpotModel& spots,
                               std::vector<std::shared_ptr<const TemplateBank>> own)
    : spots_(spots),
      model_(std::make_shared<TemplateBank>(
          spots, ModelShape(spots, 1.5 * matched_window(spots.charge) + 1.0))),
      own_(std::move(own)),
      kernels_(template_kernels().back()),
      search_(search_shifts(spots.lambda_d_px)),
      half_(int(std::ceil(kCapture * spots.lambda_d_px)) + model_->columns() / 2),
      spot_half_px_(spot_geometry(spots.charge).ring_outer * spots.lambda_d_px) {}

TrackScratch MatchedTracker::make_scratch() const {
  return {std::vector<float>(std::size_t(model_->columns() * model_->rows())),
          std::vector<float>(std::size_t(model_->columns()))};
}

const TemplateBank& MatchedTracker::bank_of(int spot) const {
  const bool own = spot >= 0 && std::size_t(spot) < own_.size() && own_[std::size_t(spot)];
  return own ? *own_[std::size_t(spot)] : *model_;
}

SpotFix MatchedTracker::track(const ImageView& image, Vec2 start_px, TrackScratch& scratch,
                              int spot) const {
  SpotFix fix;
  if (!holds(image, start_px, 0.0)) return fix;  // a start that is not a number, too
  const TemplateBank& bank = bank_of(spot);
  const double reach_px = kCapture * spots_.lambda_d_px;
  MatchedFit fit(bank, kernels_, image, spots_, scratch);
  const auto found = [&](Vec2 from) {
    if (!fit.follow(from, start_px, reach_px)) return false;
    const Vec2 at = fit.found();
    return norm(at - start_px) <= reach_px && holds(image, at, spot_half_px_) && fit.is_spot();
  };
  bool good = found(start_px);
  if (!good) {
    Vec2 best = start_px;
    double most = 0.0;
    for (const Vec2 shift : search_) {
      const double score = fit.score(start_px + shift);
      if (score > most) best = start_px + shift;
      most = std::max(most, score);
    }
    good = most > 0.0 && found(best);
  }
  const Vec2 at = good ? fit.found() : start_px;
  fix.peak = brightest_pixel(image, at, int(std::ceil(spot_half_px_)));
  if (!good) return fix;
  fix.x = float(at.x);
  fix.y = float(at.y);
  fix.quality = float(fit.quality());
  fix.level = float(fit.amplitude()) * bank.mean_bright();
  return fix;
}

}  // namespace ovws
