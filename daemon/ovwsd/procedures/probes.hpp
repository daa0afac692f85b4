/// Probes: single spots with a known grating, and the scan of the pupil with one, by registration,
/// flatness and map.
#pragma once

#include <optional>
#include <vector>

#include "core/optics/geometry.hpp"
#include "core/tracking/tracker.hpp"
#include "core/wavefront/surface_scan.hpp"
#include "daemon/ovwsd/procedures/bench.hpp"

namespace ovws {

/// Measures images of probes, in the thread of one procedure.
class ProbeBench {
 public:
  /// Averages `frames` frames for each image.
  ProbeBench(Bench& bench, int frames) : bench_(bench), frames_(frames) {}

  /// Shows the probe and returns its image minus the image without a probe, DN. NaN at pixels that
  /// were saturated in a frame. Errors: those of Bench; Errc::refused, field "camera": the camera's
  /// region changed during the job.
  Result<Image<float>> light(const Probe& probe);

 private:
  Bench& bench_;
  int frames_;
  std::optional<Image<float>> without_;
};

constexpr int kMaxProbeCharge = 2;  ///< either sign
constexpr double kProbeRim = 1.5;   ///< lambda/d: a spot closer to the edge is cut off

struct ProbeSpot {
  Vec2 rough;                ///< centre of the intensity, camera pixels
  std::optional<Vec2> fine;  ///< position found by find_probe, camera pixels; none: not found
};

/// Finds the spot in an image of ProbeBench::light. None: no spot is above the noise, or the spot
/// is closer than kProbeRim to the image's edge. Errors:
/// saturated_spot().
Result<std::optional<ProbeSpot>> probe_spot(const Image<float>& light, const SpotModel& spots);

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
  PupilScan(Bench& bench, const SensorSnapshot& now, int frames, int rings = kScanRings);

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
