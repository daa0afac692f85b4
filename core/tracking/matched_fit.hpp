/// One template fit of the matched filter: Gauss-Newton iteration and noise estimate.
#pragma once

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/template_bank.hpp"
#include "core/tracking/template_sums.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// The fit of one spot in one frame, made by MatchedTracker. The scratch must hold a window of the
/// bank's size and one more row. All methods are RT-safe.
class MatchedFit {
 public:
  MatchedFit(const TemplateBank& bank, const TemplateKernels& kernels, const ImageView& image,
             const SpotModel& spots, TrackScratch& scratch);

  /// Gauss-Newton iteration from `from`, at most `reach_px` away from `start`. True if it converged
  /// with a positive amplitude.
  bool follow(Vec2 from, Vec2 start, double reach_px) OVWS_NONBLOCKING;

  /// Squared amplitude of the template at `at`, to compare positions; 0 if the amplitude is not
  /// positive.
  double score(Vec2 at) OVWS_NONBLOCKING;

  /// Call it after other code has written to the scratch.
  void invalidate_window() OVWS_NONBLOCKING { loaded_ = false; }

  /// Whether the fit that `follow` converged to is a spot. Sets quality() and noise().
  bool is_spot() OVWS_NONBLOCKING;

  Vec2 found() const;                                          ///< image pixels
  double amplitude() const { return double(fit_.amplitude); }  ///< DN
  double quality() const { return quality_; }                  ///< [0, 1]
  double noise() const { return noise_; }                      ///< RMS pixel noise, DN

 private:
  /// Interpolation between two fits: `weight` = 0 is the fit at the middle noise level, 1 that at
  /// level `next`.
  struct NoiseMix {
    int next = kMiddleNoise;
    float weight = 0.0F;
  };

  void load(const TemplateBank::Place& place);
  TemplateFit fit_at(const TemplateBank::Place& place, int level);
  bool solve(const TemplateBank::Place& place);
  bool settle();
  NoiseMix estimate_noise();
  void interpolate(NoiseMix noise);
  bool broyden_step(NoiseMix noise);
  TemplateBank::Place neighbour(Vec2 direction) const;
  int count_of(int part) const;
  double mean_of(int part) const;
  bool is_complete(double noise) const;

  const TemplateBank& bank_;
  const TemplateKernels& kernels_;
  const ImageView& image_;
  TrackScratch& scratch_;
  double max_move_px_;
  double max_misfit_;
  bool loaded_ = false;  ///< the scratch holds the window around this pixel
  int window_x_ = 0, window_y_ = 0;
  TemplateBank::Place place_;
  TemplateFit fit_;
  TemplateFit middle_, next_;  ///< the converged fit, at two noise levels
  Vec2 move_;                  ///< spot's position minus the place's centre, px
  ResidualSums sums_;
  double quality_ = 0.0;
  double noise_ = 0.0;
};

}  // namespace ovws
