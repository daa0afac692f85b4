#include "core/spots/position_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/spots/wavefront_fit.hpp"
#include "core/tracking/plane_tracker.hpp"
#include "core/tracking/spot_geometry.hpp"

namespace ovws {
namespace {

// Radius of the fitted pixels, units of the dark ring's radius: neighbouring spots lie beyond.
constexpr double kDisc = 0.9;
constexpr double kCapture = 1.0;         // largest distance from the start, lambda/d
constexpr double kMaxStepLambdaD = 0.2;  // largest step per rendering, lambda/d
constexpr double kConvergedPx = 3e-4;
constexpr double kConvergedShare = 0.03;  // fraction of the position's standard error
constexpr int kMaxRenderings = 16, kMovedWindows = 4;
// Unexplained intensity over that of the ideal spot: aberrations within the subaperture add some.
constexpr double kMaxUnexplained = 1.0;

/// Radius of the disc, units of lambda/d: half the window's width.
double disc_radius(int charge) {
  return kDisc * spot_geometry(charge).dark;
}

}  // namespace

PositionFit::PositionFit(const SpotModel& spots, std::unique_ptr<const SpotTracker> lg)
    : spots_(spots),
      shape_(spots, 2.0 * disc_radius(spots.charge) + 1.0),
      window_(window_of(spots.lambda_d_px, disc_radius(spots.charge))),
      lg_(std::move(lg)) {}

RenderedSpot PositionFit::rendered(Vec2 at_px, const SpotWindow& window) const {
  RenderedSpot spot;
  spot.window = window;
  spot.place_px = at_px;
  spot.light.setZero(window.cells());
  spot.per_px.setZero(window.cells(), 2);
  const PixelBox box = window.pixels();
  const float share = 1.0F / float(window.bin * window.bin);
  const double disc_px = disc_radius(spots_.charge) * spots_.lambda_d_px;
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const Vec2 from_spot = Vec2{double(box.x + x), double(box.y + y)} - at_px;
      const ShapeSample sample = shape_.at(from_spot);
      const Eigen::Index cell = y / window.bin * window.side + x / window.bin;
      spot.light(cell) += share * float(sample.value);
      // Pixels at the disc's edge count in part: with a hard edge the position could not converge.
      const float inside = share * float(std::clamp(disc_px + 0.5 - norm(from_spot), 0.0, 1.0));
      spot.per_px(cell, 0) -= inside * float(sample.dx);
      spot.per_px(cell, 1) -= inside * float(sample.dy);
    }
  }
  spot.per_wave = spot.per_px;
  return spot;
}

SpotFix PositionFit::track(const ImageView& image, Vec2 start_px, TrackScratch& scratch) const {
  SpotFix fix = lg_->track(image, start_px, scratch);
  const SpotFix lost{.peak = fix.peak};
  const int pixels = window_.side * window_.bin;
  const bool inside = start_px.x >= 0.0 && start_px.y >= 0.0 && start_px.x <= image.width - 1.0 &&
                      start_px.y <= image.height - 1.0;
  if (!inside || image.width < pixels || image.height < pixels) return lost;
  Vec2 at = fix.found() ? Vec2{double(fix.x), double(fix.y)} : start_px;
  PixelNoise noise;
  SpotWindow window = window_;
  for (int k = 0; k < kMaxRenderings; ++k) {
    // Move the window only at first, so that the position cannot alternate between two windows.
    if (k < kMovedWindows) window = moved_to(at, window, image.width, image.height);
    const RenderedSpot spot = rendered(at, window);
    if (!is_inside(spot)) return lost;
    if (k == 0) noise = noise_of(image, {&spot, 1});
    const SpotPass pass = fit_spots(image, {&spot, 1}, noise, 2, Saturated::used);
    const SpotEstimates& found = pass.found.front();
    if (!(found.level > 0.0F)) return lost;
    Vec2 step = Vec2{double(found.x), double(found.y)} - at;
    const double length = norm(step), most = kMaxStepLambdaD * spots_.lambda_d_px;
    if (length > most) step = (most / length) * step;
    at = at + step;
    if (!(norm(at - start_px) <= kCapture * spots_.lambda_d_px)) return lost;
    const SpotTemplates& made = pass.templates.front();
    const double error_px = made.px_error / (double(found.level) * window_.bin * window_.bin);
    if (length > std::max(kConvergedPx, kConvergedShare * error_px)) continue;
    const double excess = std::max(excess_intensity(made, found), 0.0);
    if (excess > kMaxUnexplained) return lost;
    fix.x = float(at.x), fix.y = float(at.y);
    fix.quality = float(1.0 / (1.0 + excess));
    fix.level = found.level;
    fix.noise = float(std::sqrt(noise.constant_dn2));
    return fix;
  }
  return lost;
}

Result<std::unique_ptr<const SpotTracker>> make_position_fit(const SpotModel& spots) {
  const SpotModel lit = spots.on_plane();
  auto lg = make_tracker({TrackerKind::lg}, lit);
  if (!lg) return lg;
  return on_plane(std::make_unique<PositionFit>(lit, std::move(*lg)), spots);
}

}  // namespace ovws
