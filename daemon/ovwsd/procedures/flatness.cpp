#include "daemon/ovwsd/procedures/measurements.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/surface_scan.hpp"
#include "daemon/ovwsd/procedures/probes.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"

namespace ovws {
namespace {

constexpr int kMaxScans = 5;
constexpr double kMaxFlatnessChange = 0.01;  // waves RMS: a larger change is refused
constexpr double kMaxScanResidual = 0.1;     // lambda/d RMS: limit of the fit residual
// The scans have converged when the modes change by less than this, or than this many of their
// standard errors.
constexpr double kConvergedWaves = 0.003, kConvergedSigmas = 2.0;
// Probe diameter relative to a subaperture. A bright spot's peak scales with the diameter's fourth
// power. A vortex of charge 1 has 1/4 of a bright spot's peak, and a vortex of charge 2 has 1/10.
constexpr double kProbeDiameter = 0.7, kProbeDiameterHighCharge = 0.5;

ScanGrid grid_of(const SensorConfig& sensor) {
  const double part = std::abs(sensor.charge) <= 1 ? kProbeDiameter : kProbeDiameterHighCharge;
  return scan_grid(sensor.pupil_diameter_px,
                   part * sensor.pupil_diameter_px / sensor.subapertures_across);
}

/// Shows a bright spot from each position of a ScanGrid, and fits the modes to its displacements.
class PupilScan {
 public:
  /// `frames` are averaged at each position.
  PupilScan(Bench& bench, const SensorSnapshot& now, int frames)
      : bench_(bench),
        probes_(bench, frames),
        base_cpp_(base_grating_cpp(now.sensor, bench.geometry())),
        fit_(grid_of(now.sensor), px_per_cycle(now.optics, bench.geometry())) {
    const double subaperture_px = now.sensor.pupil_diameter_px / now.sensor.subapertures_across;
    spots_ = {0,
              lambda_d_px(now.optics, bench.geometry(), now.sensor) * subaperture_px /
                  fit_.grid().probe_diameter_px,
              lit_pixels(bench.camera().settings.pixel_format, now.optics.wavelength_nm)};
  }

  const std::vector<int>& modes_j() const { return fit_.modes_j(); }
  double spot_lambda_d_px() const { return spots_.lambda_d_px; }

  /// Scans once with `error`, except its tilts, subtracted from the hologram. `error`:
  /// RMS-normalised waves of modes_j(). The result is the whole error: the fit removes the modes
  /// shown. `from` .. `to`: this scan's share of the job's progress, within 0 .. 1. Errors: those
  /// of ProbeBench::light, probe_spot and ScanFit::fit.
  Result<ScanFit::Found> scan(const std::vector<double>& error, double from, double to) {
    std::vector<double> shown(error.size(), 0.0);
    Probe probe{base_cpp_, 0, {}, fit_.grid().probe_diameter_px, {}};
    for (std::size_t k = 0; k < error.size(); ++k) {
      if (modes_j()[k] < kFirstSurfaceMode || error[k] == 0.0) continue;
      shown[k] = -error[k];
      probe.modes.push_back({modes_j()[k], shown[k]});
    }
    std::vector<std::optional<Vec2>> at_px;
    for (const Vec2 centre : fit_.grid().centres_px) {
      probe.centre_px = centre;
      const auto light = probes_.light(probe);
      if (!light) return fail(light.error());
      const auto spot = probe_spot(*light, spots_);
      if (!spot) return fail(spot.error());
      at_px.push_back(*spot ? (*spot)->fine : std::nullopt);
      const double done = double(at_px.size()) / double(fit_.grid().centres_px.size());
      bench_.report_progress(from + done * (to - from));
    }
    return fit_.fit(at_px, shown);
  }

 private:
  Bench& bench_;
  ProbeBench probes_;
  Vec2 base_cpp_;
  ScanFit fit_;
  SpotModel spots_;
};

/// Root sum square of the difference over the modes j >= kFirstSurfaceMode.
double rms(const std::vector<int>& modes_j, const std::vector<double>& a,
           const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < modes_j.size(); ++k) {
    if (modes_j[k] >= kFirstSurfaceMode) sum += (a[k] - b[k]) * (a[k] - b[k]);
  }
  return std::sqrt(sum);
}

/// Adds the previously active flatness, which was part of the hologram during the scans.
void add_before(MeasuredFlatness& measured, const MeasuredFlatness& before) {
  for (std::size_t k = 0; k < before.modes.size(); ++k) {
    add_mode(measured.modes, before.modes[k]);
    if (measured.modes.size() == measured.standard_error_waves.size()) continue;
    measured.standard_error_waves.push_back(before.standard_error_waves[k]);
  }
}

Result<void> check_before_scan(const SensorSnapshot& now) {
  if (auto able = can_scan(now); !able) return able;
  const auto& before = now.slm->flatness;
  if (before && before->pupil_diameter_px != now.sensor.pupil_diameter_px) {
    return fail(
        Errc::refused, "sensor.pupil_diameter_px",
        fmt::format("the active flatness was measured over {} SLM pixels, but the pupil has {}: "
                    "call flatness.clear first",
                    before->pupil_diameter_px, now.sensor.pupil_diameter_px));
  }
  return {};
}

Result<void> check_flatness(const MeasuredFlatness& measured, const ScanFit::Found& last,
                            double noise_waves, double lambda_d_px) {
  if (last.residual_px > kMaxScanResidual * lambda_d_px) {
    return fail(
        Errc::refused, "",
        fmt::format("no wavefront explains the spots' positions (residual {:.2f} px RMS): check "
                    "that nothing moves, and run registration.run",
                    last.residual_px));
  }
  if (measured.residual_rms_waves <= kMaxFlatnessChange) return {};
  if (measured.residual_rms_waves < kConvergedSigmas * noise_waves) {
    return fail(
        Errc::refused, "camera.exposure_us",
        fmt::format("the spots are too weak (standard error of the modes {:.3f} waves RMS): "
                    "increase the exposure, or average more frames",
                    noise_waves));
  }
  return fail(Errc::refused, "",
              fmt::format("the scans do not converge: after {} of them the modes still change by "
                          "{:.3f} waves RMS; check that nothing moves, and run registration.run",
                          measured.iterations, measured.residual_rms_waves));
}

Result<MeasuredFlatness> flatness_at_this_exposure(Bench& bench, int frames) {
  const SensorView view = bench.sensor();
  const SensorSnapshot& now = *view;
  if (auto able = check_before_scan(now); !able) return fail(able.error());
  PupilScan scanner(bench, now, frames);
  const std::vector<double> none(scanner.modes_j().size(), 0.0);
  MeasuredFlatness measured;
  ScanFit::Found last;
  std::vector<double> error = none;
  double noise = 0.0;
  for (int k = 1; k <= kMaxScans; ++k) {
    auto seen = scanner.scan(error, double(k - 1) / kMaxScans, double(k) / kMaxScans);
    if (!seen) return fail(seen.error());
    last = std::move(*seen);
    measured.iterations = k;
    measured.residual_rms_waves = rms(scanner.modes_j(), last.waves, error);
    error = last.waves;
    noise = rms(scanner.modes_j(), last.standard_error, none);
    if (measured.residual_rms_waves < std::max(kConvergedWaves, kConvergedSigmas * noise)) break;
  }
  if (auto good = check_flatness(measured, last, noise, scanner.spot_lambda_d_px()); !good) {
    return fail(good.error());
  }
  for (std::size_t k = 0; k < error.size(); ++k) {
    if (scanner.modes_j()[k] < kFirstSurfaceMode) continue;
    measured.modes.push_back({scanner.modes_j()[k], error[k]});
    measured.standard_error_waves.push_back(last.standard_error[k]);
  }
  if (now.slm->flatness) add_before(measured, *now.slm->flatness);
  measured.t_taken_ns = utc_ns();
  measured.frames = frames;
  measured.pupil_diameter_px = now.sensor.pupil_diameter_px;
  return measured;
}

}  // namespace

Result<MeasuredFlatness> measure_flatness(Bench& bench, int frames) {
  return unsaturated(bench, [&] { return flatness_at_this_exposure(bench, frames); });
}

}  // namespace ovws
