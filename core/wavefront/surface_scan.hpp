/// Surface scan: the wavefront over the pupil, measured by moving the aperture of a probe spot.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/base/result.hpp"
#include "core/optics/geometry.hpp"

namespace ovws {

/// Scan positions of the probe's aperture, SLM pixels from the pupil's centre: in the middle and 6
/// k on ring k of 4, which finds modes up to radial order 10. The outermost apertures touch the
/// pupil's edge from inside, because high orders are undetermined where no aperture reaches.
struct ScanGrid {
  double pupil_diameter_px = 0.0;
  double probe_diameter_px = 0.0;
  std::vector<Vec2> centres_px;
};
ScanGrid scan_grid(double pupil_diameter_px, double probe_diameter_px);

/// Maximum a posteriori fit of the modes up to radial order 10 (j = 65) to the positions of a
/// bright probe spot (find_probe). The prior is a smooth surface, whose mode variance
/// falls as the fourth power of the order. A lattice aliases structure finer than its subapertures
/// into coarse modes; the overlapping apertures of a scan do not. Surfaces of up to 2.5 cycles over
/// the pupil and 0.3 waves RMS are found within 0.003 waves per mode.
class ScanFit {
 public:
  ScanFit(ScanGrid grid, const PxPerCycle& px_per_cycle);

  struct Found {
    std::vector<double> waves;           ///< in the order of modes_j, RMS-normalised
    std::vector<double> standard_error;  ///< from the residuals of the fit
    double residual_px = 0.0;            ///< RMS residual over x and y
  };

  const ScanGrid& grid() const { return grid_; }
  const std::vector<int>& modes_j() const { return modes_j_; }  ///< 1 .. 65

  /// `at_px`: position of each spot, camera pixels; none: not found. `shown`: modes in the order of
  /// modes_j that were shown during the scan; they are subtracted from the result. Tilts (j = 1, 2)
  /// are meaningless, because the position without slope is unknown. Errors (Errc::refused): more
  /// than a tenth of the spots is not found.
  Result<Found> fit(const std::vector<std::optional<Vec2>>& at_px,
                    const std::vector<double>& shown) const;

 private:
  ScanGrid grid_;
  std::vector<int> modes_j_;
  Eigen::MatrixXd slopes_;  ///< as computed by slope_matrix
};

}  // namespace ovws
