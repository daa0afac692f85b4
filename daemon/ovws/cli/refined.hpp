/// Refined measurement of image files: a maximum-likelihood fit of all pixels to the diffraction
/// model.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/wavefront/refine.hpp"
#include "daemon/ovwsd/sensor/refined_modes.hpp"

namespace ovws::cli {

/// For images of one size. Takes seconds per image; one thread at a time.
class RefinedMeasurement {
 public:
  /// `reference`: an image without aberration; its refined modes are subtracted from every result.
  /// None: results are absolute. Errors: as Refiner::make, or the reference cannot be refined.
  static Result<RefinedMeasurement> make(const Config& config, const ImageView& like,
                                         const std::optional<ImageView>& reference,
                                         const std::vector<int>& modes_j,
                                         const RefineCamera& camera, const RefineOptions& fit);

  /// `start`: coefficients from spot positions, waves; NaN counts as 0. Errors: as Refiner::refine.
  Result<RefinedModes> measure(const ImageView& image, std::span<const float> start);

 private:
  RefinedMeasurement(Refiner refiner, const RefineCamera& camera, std::size_t modes)
      : refiner_(std::move(refiner)), camera_(camera) {
    reference_.waves.assign(modes, 0.0);
    reference_.sigma_waves.assign(modes, 0.0);
  }

  Refiner refiner_;
  RefineCamera camera_;
  RefinedModes reference_;
};

}  // namespace ovws::cli
