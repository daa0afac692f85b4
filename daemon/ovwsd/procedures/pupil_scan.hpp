/// Scan of the pupil with the aperture of a single bright spot, by flatness and focus.
#pragma once

#include "core/optics/geometry.hpp"
#include "core/wavefront/surface_scan.hpp"
#include "daemon/ovwsd/procedures/probe_bench.hpp"

namespace ovws {

constexpr int kFirstSurfaceMode = 3;  ///< tilts (j = 1, 2) are not part of a surface

/// Rounds of measuring and correcting have converged when the modes change by less than this, or
/// than this many of their standard errors.
constexpr double kConvergedWaves = 0.003, kConvergedSigmas = 2.0;

/// Checks whether the light alone can be measured. Errc::refused: no registration, or a correction
/// is active.
Result<void> can_scan(const SensorSnapshot& now);

/// Shows a bright spot from each position of a ScanGrid, and fits the modes to its displacements.
/// In the thread of one procedure.
class PupilScan {
 public:
  /// `frames` are averaged at each position; `rings` as of scan_grid.
  PupilScan(Bench& bench, const SlmGeometry& slm, const SensorSnapshot& now, int frames,
            int rings = kScanRings);

  const std::vector<int>& modes_j() const { return fit_.modes_j(); }
  double spot_lambda_d_px() const { return spots_.lambda_d_px; }
  double probe_diameter_px() const { return fit_.grid().probe_diameter_px; }

  struct Scan {
    ScanFit::Found found;
    Vec2 middle_px;  ///< mean position of the spot, camera pixels
  };
  /// Scans once with `error`, except its tilts, subtracted from the hologram. `error`:
  /// RMS-normalised waves of modes_j(). The result is the whole error: the fit removes the modes
  /// shown. `from` .. `to`: this scan's share of the job's progress, within 0 .. 1. Errors: those
  /// of ProbeBench::light, probe_spot and ScanFit::fit.
  Result<Scan> scan(const std::vector<double>& error, double from, double to);

 private:
  Bench& bench_;
  ProbeBench probes_;
  Vec2 base_cpp_;
  ScanFit fit_;
  SpotModel spots_;
};

}  // namespace ovws
