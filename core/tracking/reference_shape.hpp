/// Measured templates: spot shapes from an averaged reference image.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/tracking/spot_shape.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {

/// Intensity around one position of an image, low-pass filtered and interpolated. A spot is
/// band-limited to 1 / (lambda/d) cycles per pixel: these frequencies pass unchanged, nearly all of
/// the pixel noise does not. A fit of the model's template gives the background and the amplitude,
/// which is normalised to 1.
class ReferenceShape final : public SpotShape {
 public:
  /// `model`: template bank of the same spots. Pixels outside the image repeat its edge.
  ReferenceShape(const SpotModel& spots, const TemplateBank& model, const Image<float>& average,
                 Vec2 position_px);

  /// Whether a spot was there, and every pixel around it is finite.
  bool usable() const { return amplitude_ > 0.0; }

  ShapeSample at(Vec2 from_centre) const override;

 private:
  void low_pass(const SpotModel& spots, const Image<float>& average);
  void normalise(const TemplateBank& model, const Image<float>& average);

  Vec2 position_;
  int left_ = 0, top_ = 0, side_ = 0;  ///< of `light_`, image pixels
  std::vector<float> light_;
  double background_ = 0.0;
  double amplitude_ = 0.0;
};

/// One template per reference position, for MatchedTracker. Null where the position is NaN or
/// outside the image, shows no spot, or has a NaN pixel around it. `average`: mean of the reference
/// frames, DN, of the whole region of interest, NaN where unknown; only its lit pixels are read.
/// Takes about 20 ms and (charge 1, 12.55 px) 0.9 MB per spot: off the frame path.
std::vector<std::shared_ptr<const TemplateBank>> reference_templates(
    const SpotModel& spots, const Image<float>& average, std::span<const Vec2> reference_px);

}  // namespace ovws
