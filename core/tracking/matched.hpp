/// Matched filter: weighted least-squares fit of a spot template.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/tracking/template_bank.hpp"
#include "core/tracking/template_sums.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

class MatchedFit;

/// Weighted least-squares fit of D(p) = b + a T(p - c) over a disc around the spot
/// (matched_window). Each pixel has the weight 1 / (sigma^2 + kappa a max(T, 0)); sigma^2 and kappa
/// are estimated from the same pixels, so that no camera data are needed. The RMS error of an
/// isolated spot is within a few percent of the Cramer-Rao bound (localisation_bound). Among
/// neighbours, whose diffraction tails disturb the spot, it is 10 to 25 % above.
///
/// Gauss-Newton iteration over a TemplateBank: b, a, a dx, a dy are linear at the nearest tabulated
/// shift, and the iteration changes the shift until it stays. A Broyden step then corrects the gain
/// of the last step, which is 1 only for a spot of the template's shape. Noise-free, a vortex with
/// 0.066 wave RMS of astigmatism is found to 0.002 px at any sub-pixel position. If the iteration
/// finds no spot from the start, a grid search within about 0.8 lambda/d gives the next start
/// (large spots: on binned pixels).
///
/// Lost: a fit that does not converge; a position farther than lambda/d from the start, or not
/// wholly in the image; an amplitude below 8 standard errors; a residual contrast, beyond noise, of
/// more than 1.5 (charge 0: 0.6) times what the template explains; a dark sector among 8
/// directions; a vortex without a dark core. `quality` is the template's share of the window's
/// contrast, noise subtracted. kernel_radius is not used.
///
/// The model's template suits spots of nearly ideal shape. Templates from a reference image
/// (reference_templates) suit other shapes, but include neighbours' light in the window, which does
/// not move with the spot. On the simulated bench they read 0.05 wave of a mode 2 to 6 % wrong, the
/// model's template 1 to 3 %. Configured by `tracking.template`.
class MatchedTracker final : public SpotTracker {
 public:
  /// The model's template (ModelShape) for every spot.
  explicit MatchedTracker(const SpotModel& spots);
  /// `own[i]`: template of subaperture i. Null entries and numbers out of range: the model's.
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
  std::vector<Vec2> search_;  ///< shifts of the grid search, used without a coarse bank
  int half_;
  double spot_half_px_;
};

}  // namespace ovws
