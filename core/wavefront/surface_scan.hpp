/// The wavefront over the pupil from a lone spot that was moved all over it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"

namespace ovws {

/// Where the lone spot's aperture stands, SLM pixels from the pupil's centre: 61 places, in the
/// middle and on 4 rings, of which the outermost apertures touch the pupil's edge from within:
/// where no aperture reaches, the modes of high order are free.
struct ScanGrid {
  double pupil_diameter_px = 0.0;
  double probe_diameter_px = 0.0;
  std::vector<Vec2> centres_px;
};
ScanGrid scan_grid(double pupil_diameter_px, double probe_diameter_px);

/// Modes up to radial order 10 (j = 65) from the places of the spots, which a bright probe of the
/// matched filter's slopes has. A sensor's lattice reads what is finer than its subapertures as
/// coarse modes; a scan has overlapping apertures, and does not. The estimate is the most probable
/// one of a smooth surface, whose modes' variance falls as the fourth power of their order.
/// Surfaces of up to 2.5 waves over the pupil and 0.3 waves RMS are found within 0.003 waves, a
/// mode.
class ScanFit {
 public:
  ScanFit(ScanGrid grid, const PxPerCycle& px_per_cycle);

  struct Found {
    std::vector<double> waves;           ///< as modes_j, RMS-normalised
    std::vector<double> standard_error;  ///< by what the fit leaves of the places
    double residual_px = 0.0;            ///< RMS over x and y of what it leaves
  };

  const ScanGrid& grid() const { return grid_; }
  const std::vector<int>& modes_j() const { return modes_j_; }  ///< 1 .. 65

  /// `at_px`: where each spot was, camera pixels; none: not found. `shown`: the modes, as modes_j,
  /// that were shown on top, and are taken off the result. The place without a slope is unknown, so
  /// that tilts (j = 1, 2) mean nothing. Errors (Errc::refused): more than a tenth is not found.
  Result<Found> fit(const std::vector<std::optional<Vec2>>& at_px,
                    const std::vector<double>& shown) const;

 private:
  ScanGrid grid_;
  std::vector<int> modes_j_;
  Eigen::MatrixXd slopes_;  ///< as of slope_matrix
};

}  // namespace ovws
