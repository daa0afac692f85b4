/// The refined measurement of image files: every pixel against the diffraction model.
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

/// For images of one size. Seconds an image; one thread at a time.
class RefinedMeasurement {
 public:
  /// `reference`: an image without aberration, refined itself and subtracted; none: absolute.
  /// Errors: as of Refiner::make and of refining the reference.
  static Result<RefinedMeasurement> make(const Config& config, const ImageView& like,
                                         const std::optional<ImageView>& reference,
                                         const std::vector<int>& modes_j,
                                         const RefineCamera& camera, const RefineOptions& fit);

  /// `start`: the tracked estimate; NaN where there is none. Errors as of Refiner::refine.
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
