#include "core/tracking/plane_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ovws {
namespace {

constexpr double kAgree = 0.4;  // largest difference of two planes' fixes, units of lambda/d

class ColourPlaneTracker final : public SpotTracker {
 public:
  ColourPlaneTracker(std::unique_ptr<const SpotTracker> tracker, const SpotModel& spots)
      : tracker_(std::move(tracker)),
        lit_(spots.lit),
        agree_px_(float(kAgree * spots.lambda_d_px)) {}

  TrackScratch make_scratch() const override { return tracker_->make_scratch(); }

  SpotFix track(const ImageView& image, Vec2 start_px,
                TrackScratch& scratch) const OVWS_NONBLOCKING override {
    const SpotFix fix = track_on(lit_.plane, image, start_px, scratch);
    if (!lit_.diagonal) return fix;
    return merged(fix, track_on(lit_.other(), image, start_px, scratch));
  }

 private:
  SpotFix track_on(const ColourPlane& plane, const ImageView& image, Vec2 start_px,
                   TrackScratch& scratch) const OVWS_NONBLOCKING {
    SpotFix fix = tracker_->track(on_plane(image, plane), plane.from_image(start_px), scratch);
    const Vec2 at = plane.to_image({double(fix.x), double(fix.y)});
    fix.x = float(at.x);  // NaN stays NaN
    fix.y = float(at.y);
    return fix;
  }

  SpotFix merged(const SpotFix& a, const SpotFix& b) const OVWS_NONBLOCKING {
    SpotFix fix = a.found() ? a : b;
    fix.peak = std::max(a.peak, b.peak);
    if (!a.found() || !b.found()) return fix;
    if (std::abs(a.x - b.x) > agree_px_ || std::abs(a.y - b.y) > agree_px_) {
      SpotFix none;
      none.peak = fix.peak;
      return none;
    }
    fix.x = 0.5F * (a.x + b.x);
    fix.y = 0.5F * (a.y + b.y);
    fix.quality = 0.5F * (a.quality + b.quality);
    fix.level = 0.5F * (a.level + b.level);
    fix.noise = 0.5F * (a.noise + b.noise);
    return fix;
  }

  std::unique_ptr<const SpotTracker> tracker_;
  LitPixels lit_;
  float agree_px_;
};

}  // namespace

std::unique_ptr<const SpotTracker> on_plane(std::unique_ptr<const SpotTracker> tracker,
                                            const SpotModel& spots) {
  if (spots.lit.plane.everything()) return tracker;
  return std::make_unique<ColourPlaneTracker>(std::move(tracker), spots);
}

}  // namespace ovws
