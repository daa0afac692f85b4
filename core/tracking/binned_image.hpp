/// A binned image: means over square bins, minus the background, with a noise estimate.
#pragma once

#include <Eigen/Core>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

struct BinnedImage {
  int bin = 1;  ///< pixels of the colour plane per side of a bin
  ColourPlane plane{};
  Eigen::MatrixXf intensity;  ///< bin means, DN above the image's median; rows along y
  double noise = 1.0;         ///< RMS noise of a dark bin, DN, from the median absolute deviation

  Vec2 to_bins(Vec2 px) const { return (1.0 / bin) * (plane.from_image(px) - middle()); }
  Vec2 to_px(Vec2 bins) const { return plane.to_image(double(bin) * bins + middle()); }

 private:
  Vec2 middle() const { return {0.5 * (bin - 1), 0.5 * (bin - 1)}; }  ///< centre of bin (0, 0)
};

/// Bins `image` by bin x bin pixels of the colour plane `plane`. Incomplete bins at the right and
/// at the bottom are dropped. The image must hold at least one bin. Allocates.
BinnedImage binned(const ImageView& image, const ColourPlane& plane, int bin);

/// Change detection: whether two images differ in size, or by more than their noise plus 2 % of
/// their contrast energy. Moving every spot by about 0.06 lambda/d reaches this limit.
bool is_other_image(const BinnedImage& before, const BinnedImage& now);

}  // namespace ovws
