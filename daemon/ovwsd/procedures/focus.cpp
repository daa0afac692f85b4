#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/probe_bench.hpp"
#include "daemon/ovwsd/procedures/pupil_scan.hpp"
#include "daemon/ovwsd/procedures/saturation.hpp"
#include "daemon/ovwsd/procedures/vortex_bench.hpp"

namespace ovws {
namespace {

constexpr int kCoarseRings = 2;       // 19 positions: modes up to radial order 4, to 0.1 wave
constexpr double kCoarseShare = 0.4;  // of the job's progress
constexpr int kMaxRounds = 5;
constexpr int kLastFocusMode = 14;  // of the result
constexpr int kDefocus = 4;
constexpr double kMaxFocusChange = 0.02;    // waves RMS: a larger change is refused
constexpr double kMaxImageResidual = 0.06;  // RMS of the pixels, of the brightest
constexpr double kMinLambdaPx = 1.2;        // lit camera pixels per lambda/D

Result<void> check_view(const SensorSnapshot& now, const VortexBeam& beam, const Roi& roi,
                        double scan_lambda_d_px) {
  const double lambda_px = beam.lambda_d_px() / beam.lit.plane.step;
  if (lambda_px < kMinLambdaPx) {
    return fail(Errc::refused, "optics",
                fmt::format("lambda/D of the whole pupil is {:.2f} camera pixels, at least {} are "
                            "needed to see the vortex: use a longer focal length or a larger "
                            "magnification",
                            lambda_px, kMinLambdaPx));
  }
  const Vec2 base = base_spot_px(now.optics, roi.width, roi.height);
  const double rim = std::max(kVortexWindow * beam.lambda_d_px(), kProbeRim * scan_lambda_d_px);
  if (base.x >= rim && base.y >= rim && base.x <= roi.width - 1 - rim &&
      base.y <= roi.height - 1 - rim) {
    return {};
  }
  return fail(Errc::refused, "camera.roi",
              fmt::format("the base spot is expected at ({:.0f}, {:.0f}) in the region of {} x {} "
                          "pixels, but must be {:.0f} pixels from its edge: move or enlarge the "
                          "region",
                          base.x, base.y, roi.width, roi.height, std::ceil(rim)));
}

/// What the rounds know: the modes shown, and the last fit about them.
struct Rounds {
  std::vector<Mode> shown;
  VortexPath last;
  int done = 0;
  double change = 0.0, noise = 0.0;  ///< of the last round, waves RMS
};

/// Compensates what the scan has found, up to radial order 4.
std::vector<Mode> opposite(const std::vector<int>& modes_j, const std::vector<double>& waves) {
  std::vector<Mode> shown;
  for (std::size_t k = 0; k < waves.size(); ++k) {
    if (modes_j[k] < kFirstSurfaceMode || modes_j[k] > kLastFocusMode) continue;
    shown.push_back({modes_j[k], -waves[k]});
  }
  return shown;
}

double root_sum_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum);
}

/// Modes found by the last fit that belong to the result, in the order of Rounds::shown.
struct LastModes {
  std::vector<double> waves, standard_error;
};
LastModes last_modes(const Rounds& rounds) {
  LastModes out;
  for (const Mode& mode : rounds.shown) {
    const auto found = std::ranges::find(rounds.last.modes, mode.j, &Mode::j);
    out.waves.push_back(found->waves);
    out.standard_error.push_back(
        rounds.last.standard_error[std::size_t(found - rounds.last.modes.begin())]);
  }
  return out;
}

Result<Rounds> measure_rounds(Bench& bench, VortexBench& vortex, std::vector<Mode> shown,
                              Vec2 middle_px) {
  Rounds rounds;
  rounds.shown = std::move(shown);
  while (true) {
    const double share = (1.0 - kCoarseShare) / kMaxRounds;
    const double from = kCoarseShare + share * rounds.done;
    const auto images = vortex.images(rounds.shown, from, from + share);
    if (!images) return fail(images.error());
    auto path = fit_vortex_path(*images, vortex.beam(), middle_px);
    if (!path) return fail(path.error());
    if (bench.stopped()) return fail(Errc::refused, "", "the job was stopped");
    rounds.last = std::move(*path);
    middle_px = rounds.last.middle_px;
    const LastModes found = last_modes(rounds);
    rounds.change = root_sum_square(found.waves);
    rounds.noise = root_sum_square(found.standard_error);
    ++rounds.done;
    const bool converged =
        rounds.change < std::max(kConvergedWaves, kConvergedSigmas * rounds.noise);
    if (converged || rounds.done == kMaxRounds) return rounds;
    for (std::size_t k = 0; k < rounds.shown.size(); ++k) rounds.shown[k].waves -= found.waves[k];
  }
}

Result<void> check_rounds(const Rounds& rounds) {
  if (rounds.last.residual > kMaxImageResidual) {
    return fail(Errc::refused, "",
                fmt::format("no wavefront explains the images of the vortex (residual {:.0f} % of "
                            "the brightest pixel): average more frames, check that nothing moves "
                            "and that no other light falls there, and run registration.run",
                            100.0 * rounds.last.residual));
  }
  if (rounds.change < std::max(kMaxFocusChange, kConvergedSigmas * rounds.noise)) return {};
  return fail(Errc::refused, "",
              fmt::format("the rounds do not converge: after {} of them the modes still change by "
                          "{:.3f} waves RMS; check that nothing moves, and run registration.run",
                          rounds.done, rounds.change));
}

FocusReport report_of(const Rounds& rounds, const SensorSnapshot& now, const SlmGeometry& slm) {
  FocusReport report;
  report.t_taken_ns = utc_ns();
  report.rounds = rounds.done;
  report.images = rounds.done * int(vortex_axes().size());
  report.pupil_diameter_px = now.sensor.pupil_diameter_px;
  const LastModes last = last_modes(rounds);
  for (std::size_t k = 0; k < rounds.shown.size(); ++k) {
    const Mode mode{rounds.shown[k].j, last.waves[k] - rounds.shown[k].waves};
    report.modes.push_back({{mode}, last.standard_error[k]});
    if (mode.j != kDefocus) continue;
    report.defocus_waves = mode.waves;
    report.defocus_standard_error_waves = last.standard_error[k];
  }
  const double mm_per_wave = camera_shift_mm_per_wave(now.optics, slm, report.pupil_diameter_px);
  report.camera_shift_mm = mm_per_wave * report.defocus_waves;
  report.camera_shift_standard_error_mm =
      std::abs(mm_per_wave) * report.defocus_standard_error_waves;
  if (const auto& flatness = now.slm->flatness) {
    report.flatness_defocus_waves = 0.0;
    for (const Mode& mode : flatness->modes) {
      if (mode.j == kDefocus) report.flatness_defocus_waves = mode.waves;
    }
  }
  report.change_rms_waves = rounds.change;
  report.middle_px = rounds.last.middle_px;
  for (std::size_t k = 0; k < rounds.last.cores_px.size(); ++k) {
    report.path.push_back({vortex_axes()[k], rounds.last.cores_px[k]});
  }
  report.motion_px = rounds.last.motion_px;
  return report;
}

}  // namespace

Result<FocusReport> measure_focus(Bench& bench, const SlmGeometry& slm, int frames) {
  const SensorView view = bench.sensor();
  const SensorSnapshot& now = *view;
  if (auto able = can_scan(now); !able) return fail(able.error());
  double probe_px = 0.0;
  std::vector<Mode> shown;
  const auto coarse = unsaturated(bench, [&]() -> Result<PupilScan::Scan> {
    PupilScan scan(bench, slm, now, frames, kCoarseRings);
    probe_px = scan.probe_diameter_px();
    const VortexBench vortex(bench, slm, now, frames, probe_px, {});
    const Roi roi = bench.camera().settings.roi;
    if (auto able = check_view(now, vortex.beam(), roi, scan.spot_lambda_d_px()); !able) {
      return fail(able.error());
    }
    auto seen = scan.scan(std::vector<double>(scan.modes_j().size(), 0.0), 0.0, kCoarseShare);
    if (seen) shown = opposite(scan.modes_j(), seen->found.waves);
    return seen;
  });
  if (!coarse) return fail(coarse.error());
  VortexBench vortex(bench, slm, now, frames, probe_px, coarse->middle_px);
  const auto rounds = measure_rounds(bench, vortex, shown, coarse->middle_px);
  if (!rounds) return fail(rounds.error());
  if (auto good = check_rounds(*rounds); !good) return fail(good.error());
  FocusReport report = report_of(*rounds, now, slm);
  report.frames = frames;
  report.exposure_us = bench.camera().settings.exposure_us;
  return report;
}

}  // namespace ovws
