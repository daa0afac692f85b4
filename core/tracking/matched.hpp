/// The matched filter: the spot's known picture moved until it fits best.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/tracking/template_bank.hpp"
#include "core/tracking/template_sums.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

class MatchedFit;

/// Least squares of D(p) = b + a T(p - c) over a disc around the spot (matched_window), each pixel
/// weighted by 1 / (sigma^2 + kappa a max(T, 0)), sigma^2 and kappa estimated from the same pixels:
/// at the Cramer-Rao bound (localisation_bound) to a few percent for a spot by itself, 10 to 25 %
/// above it among neighbours, whose light ripples on the spot; whatever the camera.
///
/// Gauss-Newton over a TemplateBank: b, a, a dx, a dy are linear at the nearest of its shifts, and
/// the shift is followed until it stays. A Broyden step there corrects the step's gain, which is 1
/// only for a spot of the template's shape: noise-free, a vortex with 0.066 wave RMS of astigmatism
/// is within 0.002 px of where it is, wherever that lies between the shifts. If that does not lead
/// from the start to a spot, the best of the shifts within about 0.8 lambda/d, of large spots in
/// binned pixels, is the next start. Lost: what does not come to rest; is further than lambda/d
/// from the start, or not wholly in the image; has an amplitude below 8 standard errors; leaves
/// more contrast than noise explains and 1.5 (charge 0: 0.6) of what the template explains; is dark
/// in one of 8 directions; or is a vortex without a dark core. quality: the template's share of the
/// window's contrast, noise taken out. kernel_radius plays no part.
///
/// The model's template is the choice for spots that are nearly the model's. Those of a reference
/// image (reference_templates) follow spots of another shape, but take a neighbour's light in the
/// window for the spot's, which does not move with it: on the simulated bench they read 0.05 wave
/// of a mode 2 to 6 % wrong, the model's 1 to 3 %. `tracking.template` chooses.
class MatchedTracker final : public SpotTracker {
 public:
  /// The model's template (ModelShape) for every spot.
  explicit MatchedTracker(const SpotModel& spots);
  /// `own[i]` for subaperture i; null, or a number beyond: the model's.
  MatchedTracker(const SpotModel& spots, std::vector<std::shared_ptr<const TemplateBank>> own);

  int window_half_px() const override { return half_; }
  TrackScratch make_scratch() const override;
  bool per_spot() const override { return !own_.empty(); }
  SpotFix track(const ImageView& image, Vec2 start_px, TrackScratch& scratch,
                int spot = kAnySpot) const OVWS_NONBLOCKING override;

 private:
  const TemplateBank& bank_of(int spot) const;
  std::optional<Vec2> fine_start(MatchedFit& fit, Vec2 start) const;

  SpotModel spots_;
  std::shared_ptr<const TemplateBank> model_;
  std::vector<std::shared_ptr<const TemplateBank>> own_;
  const TemplateKernels& kernels_;
  std::vector<Vec2> search_;  ///< shifts to try where there is no coarse bank
  int half_;
  double spot_half_px_;
};

}  // namespace ovws
