/// Correction of rendered spots by those that a calibration measured.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/spots/measured_spots.hpp"

namespace ovws {

class SpotRenderer;

/// What a model does not know of a bench: the differences between measured and rendered spots of
/// the calibration's wavefront, and of their derivatives, as a straight line over the wavefront.
/// Where a spot has half of its light, this halves the error of 44 modes at 0.05 wave RMS. Farther
/// away the correction fades out.
class SpotCorrection {
 public:
  /// Compares `measured` with `renderer`, which pokes the modes as the calibration did: some 15 ms
  /// per mode. `at_waves`: the calibration's wavefront, one value for each mode of both. `renderer`
  /// must not have a correction. None: the pokes are not known, or the pixels are binned otherwise.
  static std::optional<SpotCorrection> make(SpotRenderer& renderer, const MeasuredShapes& measured,
                                            std::span<const double> at_waves);

  /// Corrects the spots of a rendering of the wavefront `waves` plus `fixed`.
  void add_to(std::span<RenderedSpot> spots, std::span<const double> waves,
              std::span<const Mode> fixed) const;

 private:
  struct Difference {
    SpotWindow window;
    Eigen::VectorXf light;  ///< empty: the spot is dark
    Eigen::MatrixXf per_wave;
  };
  double distance_waves(std::span<const double> waves, std::span<const Mode> fixed) const;

  std::vector<double> at_waves_;
  std::vector<Mode> fixed_;
  std::vector<Difference> differences_;
};

}  // namespace ovws
