/// Spots as the bench itself shows them: templates from an averaged reference image.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/tracking/spot_shape.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {

/// The light around one position of an image, low-passed and interpolated. A spot's light has no
/// frequencies above 1 / (lambda/d) cycles per pixel: those pass unchanged, and nearly all of the
/// pixels' noise does not. The model's template, fitted, tells what is background and what
/// amplitude is 1.
class ReferenceShape final : public SpotShape {
 public:
  /// `model`: of the same spots. Where the image ends, its edge is repeated.
  ReferenceShape(const SpotModel& spots, const TemplateBank& model, const Image<float>& average,
                 Vec2 position_px);

  /// Whether a spot was there, and every pixel about it is a number.
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

/// A template for each reference position, for MatchedTracker; null where the position is not a
/// number, shows no spot, or has a pixel about it that is none. `average`: mean of the reference
/// frames, DN, of the whole region of interest, NaN where it is not known; only its lit pixels are
/// read. About 20 ms and (charge 1, 12.55 px) 0.9 MB a spot: off the frame path.
std::vector<std::shared_ptr<const TemplateBank>> reference_templates(
    const SpotModel& spots, const Image<float>& average, std::span<const Vec2> reference_px);

}  // namespace ovws
