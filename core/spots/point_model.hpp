/// Finds the operating point of an image and renders templates about it.
#pragma once

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

/// Of one sensor on one bench. Use it from one thread at a time, off the frame path: a rendering
/// takes some 15 ms on the default bench, and a reference ten of them, or fifty on a bench that is
/// very unlike the model.
class PointModel {
 public:
  /// `estimates`: of each spot, 2 to kMaxSpotEstimates.
  PointModel(SpotRenderer renderer, int estimates)
      : renderer_(std::move(renderer)), estimates_(estimates) {}

  /// Fits the image of a reference: its wavefront, from which coefficients count, and what the
  /// bench does differently from the model over each subaperture (SpotDeviations). `start_waves` is
  /// near its wavefront; `fixed`: modes shown that are not measured. Errc::refused, field
  /// "reference": the model does not explain the image.
  Result<void> use_reference(const ImageView& image, const PixelNoise& noise,
                             std::span<const double> start_waves, std::span<const Mode> fixed);
  /// Coefficients count from the model's flat wavefront, and the bench is as the model has it.
  void use_model();
  /// Its wavefront, waves, and the standard errors; 0 for the model's.
  const std::vector<double>& reference_waves() const { return reference_waves_; }
  const std::vector<double>& reference_sigma_waves() const { return reference_sigma_waves_; }
  /// Relative amplitude of the field at the centre of a subaperture; without a reference 1.
  double amplitude(int spot) const;
  /// Renderings that the last reference or wavefront took.
  int renderings() const { return renderings_; }
  std::vector<RenderedSpot> rendered(std::span<const double> waves) {
    return renderer_.render(waves);
  }

  /// Coefficients, which count from the reference, from where to look for a wavefront.
  using Starts = std::span<const std::vector<double>>;
  /// Templates about the wavefront of the last of `images`, found from the first of `starts` that
  /// leads to it, in at most `renderings` each. The images before it give the noise (noise_of). If
  /// none does, a few more renderings about the nearest allow for modes above the measured ones.
  /// From a flat start, 12 renderings find 0.8 wave RMS in 59 of 60 images (j = 3 to 18).
  /// Errc::refused, field "image": the spots do not look as rendered.
  Result<std::shared_ptr<const FrameFit>> templates(std::span<const ImageView> images,
                                                    Starts starts, std::span<const Mode> fixed,
                                                    int renderings);
  /// The same for a single image, which gives its noise, too.
  Result<std::shared_ptr<const FrameFit>> templates(const ImageView& image, Starts starts,
                                                    std::span<const Mode> fixed, int renderings);
  /// The same for a single image whose noise is known.
  Result<std::shared_ptr<const FrameFit>> templates(const ImageView& image, const PixelNoise& noise,
                                                    Starts starts, std::span<const Mode> fixed,
                                                    int renderings);

 private:
  struct Found {
    std::vector<double> waves;  ///< of the rendering
    std::vector<RenderedSpot> rendered;
    SpotPass pass;
    Eigen::VectorXd step;     ///< from the rendering to the image
    double away_waves = 0.0;  ///< its size
    std::vector<double> sigma_waves;
  };
  Result<Found> approach(const ImageView& image, const PixelNoise& noise, std::vector<double> waves,
                         std::vector<RenderedSpot> rendered, std::span<const Mode> fixed,
                         double near_waves, int renderings);
  std::optional<Found> with_higher_modes(const ImageView& image, const PixelNoise& noise,
                                         Found found, std::span<const Mode> fixed);
  bool are_explained_by(double higher_waves, const Found& found) const;
  Result<Found> at_reference(const ImageView& image, const PixelNoise& noise,
                             std::vector<double> waves, std::span<const Mode> fixed,
                             const SpotDeviations& deviations);
  Result<void> count_from(const Found& found, const ImageView& image, const PixelNoise& noise,
                          std::span<const Mode> fixed);
  std::vector<double> from_reference(std::span<const double> coefficients) const;
  using NoiseFrom = std::function<PixelNoise(std::span<const RenderedSpot>)>;
  Result<std::shared_ptr<const FrameFit>> found_in(const ImageView& image,
                                                   const NoiseFrom& noise_from, Starts starts,
                                                   std::span<const Mode> fixed, int renderings);
  Result<std::shared_ptr<const FrameFit>> accepted(const Found& found, const ImageView& image,
                                                   const PixelNoise& noise,
                                                   std::span<const Mode> fixed) const;
  double allowed_excess() const;
  std::shared_ptr<FrameFit> fit_at(const Found& found, const PixelNoise& noise,
                                   std::span<const Mode> fixed) const;

  SpotRenderer renderer_;
  int estimates_;
  int renderings_ = 0;
  std::vector<double> reference_waves_, reference_sigma_waves_;
  std::vector<double> reference_levels_;  ///< of its spots, DN; 0: not found
  double reference_excess_ = 0.0, reference_residual_px_ = 0.0;
};

}  // namespace ovws
