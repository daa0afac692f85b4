/// Finds the operating point of an image and renders templates about it.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/spots/frame_fit.hpp"
#include "core/spots/spot_renderer.hpp"
#include "core/spots/wavefront_fit.hpp"

namespace ovws {

/// Diffraction model of one sensor on one bench. Use it from one thread at a time, off the frame
/// path: a rendering takes some 10 ms on the default bench. use_reference needs some ten
/// renderings, or fifty if the bench deviates strongly from the model.
class PointModel {
 public:
  /// Uses the ideal model at first. `estimates`: number of estimates per spot, 2 to
  /// kMaxSpotEstimates.
  PointModel(SpotRenderer renderer, int estimates)
      : renderer_(std::move(renderer)), estimates_(estimates) {
    use_model();
  }

  /// Fits the image of a reference: its wavefront, from which coefficients count, and the bench's
  /// deviations from the model (SpotDeviations). `start_waves` is near the reference's wavefront;
  /// `fixed`: modes on the SLM that are not measured. Errc::refused, field "reference": the model
  /// does not explain the image; field "image": the spots do not determine the modes. Of `claimed`
  /// noise no more counts than the image shows.
  Result<void> use_reference(const ImageView& image, const PixelNoise& claimed,
                             std::span<const double> start_waves, std::span<const Mode> fixed);
  /// Corrects renderings by the spots that a calibration measured (SpotCorrection, where possible),
  /// with two renderings of the light for each mode. `coefficients`: the calibration's wavefront,
  /// relative to the reference. Call after use_reference.
  void correct_by(const MeasuredShapes& measured, std::span<const double> coefficients);
  void end_correction();
  /// Uses the ideal model: coefficients count from its flat wavefront, without deviations.
  void use_model();
  /// Wavefront of the reference and its standard errors, waves; 0 after use_model.
  const std::vector<double>& reference_waves() const { return reference_waves_; }
  const std::vector<double>& reference_sigma_waves() const { return reference_sigma_waves_; }
  /// Relative amplitude of the field at the centre of a subaperture; without a reference 1.
  double amplitude(int spot) const;
  /// Number of renderings that the last use_reference or templates call took.
  int renderings() const { return renderings_; }
  std::vector<RenderedSpot> rendered(std::span<const double> waves) {
    return renderer_.render(waves);
  }

  /// Start wavefronts of a search, as coefficients relative to the reference.
  using Starts = std::span<const std::vector<double>>;
  /// Finds the wavefront of the last of `images`, of which there is at least one, and makes
  /// templates about it. Tries `starts` in order, with at most `renderings` renderings each. A
  /// start that loses no spot ends the search. If no start leads to the wavefront exactly, a few
  /// more renderings about the nearest result allow for modes above the measured ones. All images
  /// give the noise (noise_of; the smallest of the last successful searches counts). From a flat
  /// start, 12 renderings find 0.8 wave RMS in 59 of 60 images (j = 3 to 18). Errc::refused, field
  /// "image": the spots do not look as rendered.
  Result<std::shared_ptr<const FrameFit>> templates(std::span<const ImageView> images,
                                                    Starts starts, std::span<const Mode> fixed,
                                                    int renderings);
  /// Call when the camera's noise may have changed: with its gain or exposure.
  void forget_noise() { noises_.clear(); }
  /// Makes templates from a single image, which also gives the noise.
  Result<std::shared_ptr<const FrameFit>> templates(const ImageView& image, Starts starts,
                                                    std::span<const Mode> fixed, int renderings);
  /// Makes templates from a single image whose noise is known.
  Result<std::shared_ptr<const FrameFit>> templates(const ImageView& image, const PixelNoise& noise,
                                                    Starts starts, std::span<const Mode> fixed,
                                                    int renderings);

 private:
  using NoiseFrom = std::function<PixelNoise(std::span<const RenderedSpot>)>;
  struct Found {
    std::vector<double> waves;  ///< wavefront of the rendering
    std::vector<RenderedSpot> rendered;
    PixelNoise noise;
    SpotPass pass;
    Eigen::VectorXd step;     ///< modes of the image minus modes of the rendering
    double away_waves = 0.0;  ///< norm of `step`
    std::vector<double> sigma_waves;
  };
  Result<Found> approach(const ImageView& image, const NoiseFrom& noise_from,
                         std::vector<double> waves, std::span<const Mode> fixed, double near_waves,
                         int renderings);
  std::optional<Found> with_higher_modes(const ImageView& image, Found found,
                                         std::span<const Mode> fixed);
  bool are_explained_by(double higher_waves, const Found& found) const;
  PixelNoise noise_in_reference(const ImageView& image, const PixelNoise& claimed,
                                std::span<const RenderedSpot> rendered);
  Result<Found> at_reference(const ImageView& image, const PixelNoise& noise,
                             std::vector<double> waves, std::span<const Mode> fixed,
                             const SpotDeviations& deviations);
  Result<void> count_from(const Found& found, const ImageView& image, std::span<const Mode> fixed);
  std::vector<double> from_reference(std::span<const double> coefficients) const;
  Result<std::shared_ptr<const FrameFit>> found_in(const ImageView& image,
                                                   const NoiseFrom& noise_from, Starts starts,
                                                   std::span<const Mode> fixed, int renderings);
  Result<std::shared_ptr<const FrameFit>> accepted(const Found& found, const ImageView& image,
                                                   std::span<const Mode> fixed,
                                                   double max_residual) const;
  std::shared_ptr<const FrameFit> accepted_whole(const Found& found, const ImageView& image,
                                                 std::span<const Mode> fixed) const;
  PixelNoise quieter(const PixelNoise& a, const PixelNoise& b) const;
  double allowed_excess() const;
  std::shared_ptr<FrameFit> fit_at(const Found& found, std::span<const Mode> fixed) const;

  SpotRenderer renderer_;
  int estimates_;
  int renderings_ = 0;
  std::vector<double> reference_waves_, reference_sigma_waves_;
  std::vector<double> reference_levels_;  ///< levels of the reference's spots, DN; 0: not found
  double reference_excess_ = 0.0, reference_residual_px_ = 0.0;
  std::deque<PixelNoise> noises_;     ///< of the last successful searches: motion makes them larger
  std::vector<double> corrected_at_;  ///< wavefront of the calibration; empty: no correction
};

}  // namespace ovws
