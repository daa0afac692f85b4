#include "core/tracking/patch_tracker.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

// Least spare: a small patch would not suffice to estimate the noise beside a small spot.
constexpr int kLeastSparePx = 4;

int spare_px_of(double spare, double lambda_d_px) {
  return std::max(int(std::ceil(spare * lambda_d_px)), kLeastSparePx);
}

int patch_half(const SpotModel& spots, const SpotGeometry& geometry, int kernel_half_px,
               int spare_px) {
  // Two pixels more on either side: the start and the found position are each rounded to a pixel.
  const int reach = spare_px + std::max(kernel_half_px, SpotCheck::reach_px(spots, geometry)) + 2;
  return std::max(reach, kMinPatchHalf);
}

}  // namespace

PatchTracker::PatchTracker(const SpotModel& spots, int kernel_half_px, int sum_floats, double spare)
    : spots_(spots),
      geometry_(spot_geometry(spots.charge)),
      kernel_half_(kernel_half_px),
      spare_(spare_px_of(spare, spots.lambda_d_px)),
      half_(patch_half(spots_, geometry_, kernel_half_px, spare_)),
      sum_floats_(sum_floats),
      check_(spots_, geometry_, half_) {}

TrackScratch PatchTracker::make_scratch() const {
  return {std::vector<float>(std::size_t(patch_floats(half_))),
          std::vector<float>(std::size_t(sum_floats_))};
}

SpotFix PatchTracker::track(const ImageView& image, Vec2 start_px, TrackScratch& scratch) const {
  SpotFix fix;
  const bool inside = start_px.x >= 0.0 && start_px.y >= 0.0 && start_px.x <= image.width - 1.0 &&
                      start_px.y <= image.height - 1.0;
  if (!inside) return fix;  // also rejects NaN
  Patch patch = load_patch(image, int(std::lround(start_px.x)), int(std::lround(start_px.y)), half_,
                           scratch.samples);
  const double spot_half = SpotCheck::spot_half_px(spots_, geometry_);
  const std::optional<Found> found = find(patch, start_px, scratch);
  const bool good = found && found->verdict.passed && norm(found->at - start_px) <= capture_px() &&
                    patch.holds(found->at, std::max(double(kernel_half_), spot_half));
  const int peak_half = int(std::ceil(spot_half));
  fix.peak =
      good ? patch.brightest(found->at, peak_half) : brightest_pixel(image, start_px, peak_half);
  if (!good) return fix;
  fix.x = float(found->at.x);
  fix.y = float(found->at.y);
  fix.quality = float(found->verdict.quality);
  fix.level = float(found->verdict.level);
  fix.noise = float(found->verdict.noise);
  return fix;
}

}  // namespace ovws
