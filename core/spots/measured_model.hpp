/// Templates of spots whose derivatives were measured on the bench.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/result.hpp"
#include "core/spots/frame_fit.hpp"

namespace ovws {

/// Measured spot model. Its operating point stays at the wavefront of the calibration, about which
/// the modes were poked: templates are most accurate near it. Use it from one thread at a time, off
/// the frame path.
class MeasuredModel {
 public:
  /// `spots`: see measured_spots, with derivatives for `modes_j`. Coefficients count from the
  /// wavefront of the calibration until a reference is used.
  MeasuredModel(std::vector<RenderedSpot> spots, std::vector<int> modes_j, int estimates)
      : spots_(std::move(spots)),
        modes_j_(std::move(modes_j)),
        estimates_(estimates),
        reference_waves_(modes_j_.size(), 0.0),
        reference_levels_(spots_.size(), 1.0) {}

  std::span<const RenderedSpot> spots() const { return spots_; }
  /// Wavefront of the reference, relative to that of the calibration, waves.
  const std::vector<double>& reference_waves() const { return reference_waves_; }

  /// Sets the reference: coefficients count from the wavefront of this image. Errc::refused, field
  /// "reference": that wavefront is too far from the wavefront of the calibration.
  Result<void> use_reference(const ImageView& image, const PixelNoise& noise);

  /// Makes templates for the last of `images`, of which there is at least one; all give the noise
  /// (noise_of). Errc::refused, field "image": the spots differ from the measured ones.
  Result<std::shared_ptr<const FrameFit>> templates(std::span<const ImageView> images) const;

 private:
  std::vector<RenderedSpot> spots_;
  std::vector<int> modes_j_;
  int estimates_;
  std::vector<double> reference_waves_;
  std::vector<double> reference_levels_;  ///< levels of the reference's spots, DN; 0: not found
};

}  // namespace ovws
