/// The fit of a spot: from its pixels to estimates, in one pass.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/realtime.hpp"
#include "core/spots/spot_templates.hpp"

namespace ovws {

constexpr int kMaxSpotEstimates = 8;

/// Estimates from the pixels of one spot.
struct SpotEstimates {
  float level = 0.0F;       ///< DN of a camera pixel where the rendered intensity is 1; 0: no spot
  float background = 0.0F;  ///< DN of a camera pixel
  float x = 0.0F;           ///< position, camera pixels
  float y = 0.0F;
  float chi2_per_cell = 0.0F;  ///< chi-squared of the binned pixels per degree of freedom
  float peak = 0.0F;           ///< brightest camera pixel of the window, DN
  /// Template estimates: SpotTemplates::per_wave times the modes in waves. Their standard error is
  /// 1 over the level of a binned pixel.
  std::array<float, kMaxSpotEstimates> values{};
};

/// Fraction of the spot's weighted intensity that the templates do not explain, beyond noise.
double excess_intensity(const SpotTemplates& spot, const SpotEstimates& found);
/// Standard error of excess_intensity by noise, for a spot of this level, DN of a camera pixel.
double excess_scatter_of(const SpotTemplates& spot, double level_dn);

/// Spot fit by templates. Immutable; one object serves all threads, each with its own scratch.
class SpotFit {
 public:
  /// Working memory, sized by make_scratch so that `fit` never allocates.
  struct Scratch {
    std::vector<std::uint16_t> pixels;
    std::vector<float> cells, sums;
  };

  explicit SpotFit(std::vector<SpotTemplates> spots) : spots_(std::move(spots)) {}

  const std::vector<SpotTemplates>& spots() const { return spots_; }
  Scratch make_scratch() const;

  /// Fits one spot. The image has the size that the spots were rendered for. RT-safe.
  SpotEstimates fit(const ImageView& image, std::size_t spot,
                    Scratch& scratch) const OVWS_NONBLOCKING;

 private:
  std::vector<SpotTemplates> spots_;
};

}  // namespace ovws
