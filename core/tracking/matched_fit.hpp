/// One fit of a spot's template to one image.
#pragma once

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/base/vec2.hpp"
#include "core/tracking/template_bank.hpp"
#include "core/tracking/template_sums.hpp"
#include "core/tracking/tracker.hpp"

namespace ovws {

/// What MatchedTracker does at one start; nothing of it outlives the frame. The scratch holds a
/// window of the bank's pixels and one row more. RT-safe throughout.
class MatchedFit {
 public:
  MatchedFit(const TemplateBank& bank, const TemplateKernels& kernels, const ImageView& image,
             const SpotModel& spots, TrackScratch& scratch);

  /// Gauss-Newton from `from`, at most `reach_px` away from `start`: whether it came to rest on a
  /// bright template.
  bool follow(Vec2 from, Vec2 start, double reach_px) OVWS_NONBLOCKING;

  /// How much of the light's contrast a template at `at` explains, in units that only compare: 0 if
  /// it would be dark.
  double score(Vec2 at) OVWS_NONBLOCKING;

  /// After another has written to the scratch.
  void forget_window() OVWS_NONBLOCKING { loaded_ = false; }

  /// Whether what `follow` came to rest on is a spot. Sets quality() and noise().
  bool is_spot() OVWS_NONBLOCKING;

  Vec2 found() const;                                          ///< image pixels
  double amplitude() const { return double(fit_.amplitude); }  ///< DN
  double quality() const { return quality_; }                  ///< [0, 1]
  double noise() const { return noise_; }                      ///< RMS of the pixels, DN

 private:
  /// Between the fits at the middle noise level and at another: 0 is the middle one.
  struct NoiseMix {
    int next = kMiddleNoise;
    float way = 0.0F;
  };

  void load(const TemplateBank::Place& place);
  TemplateFit fit_at(const TemplateBank::Place& place, int level);
  bool solve(const TemplateBank::Place& place);
  bool settle();
  NoiseMix weigh();
  void mix(NoiseMix noise);
  bool correct(NoiseMix noise);
  TemplateBank::Place beside(Vec2 way) const;
  int count_of(int part) const;
  double mean_of(int part) const;
  bool whole(double noise) const;

  const TemplateBank& bank_;
  const TemplateKernels& kernels_;
  const ImageView& image_;
  TrackScratch& scratch_;
  double longest_move_px_;
  double max_misfit_;
  bool loaded_ = false;  ///< the window in the scratch, of this pixel
  int window_x_ = 0, window_y_ = 0;
  TemplateBank::Place place_;
  TemplateFit fit_;
  TemplateFit middle_, next_;  ///< where it came to rest, at two noise levels
  Vec2 move_;                  ///< from the place's centre, px
  ResidualSums sums_;
  double quality_ = 0.0;
  double noise_ = 0.0;
};

}  // namespace ovws
