/// Methods that measure the bench or change its hologram: aberration, calibration, correction,
/// flatness, focus, lut, registration, sensor, slm.
#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/control/sensor_handlers.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/presentation.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/record/recorder.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/devices.hpp"
#include "proto/tables/focus.hpp"
#include "proto/tables/reference.hpp"
#include "proto/tables/sensor.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/slm.hpp"

namespace ovws {
namespace {

AberrationReport aberration_of(const Services& /*services*/, const SensorSnapshot& now) {
  return {now.aberration, now.sequence, now.hologram_id};
}

ModesReport correction_of(const Services& /*services*/, const SensorSnapshot& now) {
  return {now.correction, now.hologram_id};
}

// An aberration may be introduced even while the loop is closed: the loop then corrects it.
void introduce(Services& services, const ModesSet& change, const Reply<AberrationReport>& reply) {
  edit<aberration_of>(services, set_aberration(change.modes), reply);
}

void introduce_none(Services& services, const Reply<AberrationReport>& reply) {
  introduce(services, {}, reply);
}

/// Whether the configured bench can show a sequence and take a frame of each pattern.
Result<void> check_sequence_bench(const Config& config) {
  if (config.modulator != Modulator::dmd || config.dmd.slots == 0) {
    return fail(Errc::refused, "dmd.slots",
                "there is no DMD in a pattern mode: set `modulator` to dmd and dmd.slots to the "
                "number of bits that it plays, and restart the daemon");
  }
  if (config.camera.trigger.empty()) {
    return fail(Errc::refused, "camera.trigger",
                "a camera that runs freely does not take one frame of each pattern: connect the "
                "DMD's trigger output to the camera, set camera.trigger, and restart the daemon");
  }
  if (config.beams.empty()) return {};
  return fail(Errc::refused, "beams",
              "patterns cannot be shown with several light sources: remove `beams` from the "
              "configuration, and restart the daemon");
}

/// The cycle that the DMD plays now. Errors: those of check_sequence_bench; display or camera are
/// not set for it.
Result<PatternCycle> cycle_of(const Services& services) {
  if (auto can = check_sequence_bench(services.config); !can) return fail(can.error());
  const int slots = services.config.dmd.slots;
  const SlmSnapshot slm = services.slm.snapshot();
  if (!slm.info) return fail(Errc::unavailable, "slm.display", "there is no display: " + slm.fault);
  if (!(slm.info->refresh_hz > 0.0)) {
    return fail(Errc::unavailable, "slm.display",
                "the display system does not tell the refresh rate of the DMD's output: set a mode "
                "of the output with a rate (xrandr)");
  }
  const double cycle_ms = 1e3 / slm.info->refresh_hz, period_us = 1e3 * cycle_ms / slots;
  if (slm.settings.settle_ms < 2.0 * cycle_ms) {
    return fail(
        Errc::refused, "slm.settle_ms",
        fmt::format("a DMD plays a new image up to two video frames later, {:.1f} ms: raise "
                    "settle_ms with slm.set first",
                    2.0 * cycle_ms));
  }
  const double exposure_us = services.camera.snapshot().settings.exposure_us;
  if (exposure_us > period_us) {
    return fail(
        Errc::refused, "exposure_us",
        fmt::format("an exposure of {:g} us is longer than a pattern, {:.1f} us: shorten it "
                    "with camera.set first",
                    exposure_us, period_us));
  }
  return PatternCycle{slots, std::llround(1e3 * period_us)};
}

void show_sequence(Services& services, const AberrationSequence& given,
                   const Reply<AberrationReport>& reply) {
  if (auto can = check_shows_sensor(*services.keeper.snapshot()); !can) return reply(can.error());
  if (services.recorder.report().state == "recording") {
    return reply(Error{Errc::refused, "", "a recording does not know patterns: stop it first"});
  }
  const auto cycle = cycle_of(services);
  if (!cycle) return reply(cycle.error());
  const int most = cycle->slots - 1;
  if (int(given.patterns.size()) > most) {
    return reply(Error{Errc::invalid, "patterns",
                       fmt::format("{} patterns: the DMD plays {} in a cycle, and the first is the "
                                   "dark mark: give at most {}",
                                   given.patterns.size(), cycle->slots, most)});
  }
  std::vector<std::vector<Mode>> patterns;
  for (const ModesSet& one : given.patterns) patterns.push_back(one.modes);
  edit<aberration_of>(services, set_sequence(std::move(patterns), *cycle), reply);
}

void correct(Services& services, const ModesSet& change, const Reply<ModesReport>& reply) {
  edit<correction_of>(services, set_correction(change.modes), reply);
}

void correct_nothing(Services& services, const Reply<ModesReport>& reply) {
  correct(services, {}, reply);
}

KnownCalibration calibration_of(const Services& services, const SensorSnapshot& now) {
  if (!now.calibration) return {};
  const Calibration& c = *now.calibration;
  return {now.mode_operator.in_force == OperatorKind::measured,
          CalibrationReport{c.amplitude_waves,
                            c.frames,
                            c.t_taken_ns,
                            c.matrix,
                            c.comparison,
                            c.shapes ? c.shapes->modes_j : std::vector<int>{},
                            sha256_of(services.library, c),
                            {*c.origin}}};
}

Result<Json> calibrate(const Services& services, Bench& bench, const CalibrationRun& run) {
  const std::uint64_t epoch = bench.sensor()->sensor_epoch;
  const auto measured = measure_calibration(bench, run);
  if (!measured) return fail(measured.error());
  return use<calibration_of>(services, bench, use_calibration(epoch, *measured));
}

void give(Services& services, const CalibrationSet& given, std::string matrix,
          const Reply<KnownCalibration>& reply) {
  edit<calibration_of>(services, give_calibration(given, std::move(matrix)), reply);
}

FlatnessReport flatness_of(const Services& services, const SensorSnapshot& now) {
  FlatnessReport report{services.config.slm.flatness, std::nullopt};
  const auto& f = now.slm->flatness;
  if (!f) return report;
  report.measured = FlatnessMeasured{f->t_taken_ns,
                                     f->frames,
                                     f->iterations,
                                     f->pupil_diameter_px,
                                     {},
                                     f->residual_rms_waves,
                                     sha256_of(services.library, *f),
                                     {*f->origin}};
  for (std::size_t k = 0; k < f->modes.size(); ++k) {
    report.measured->modes.push_back(
        {f->modes[k].j, f->modes[k].waves, f->standard_error_waves[k]});
  }
  return report;
}

Result<Json> flatten(const Services& services, Bench& bench, const FlatnessRun& run) {
  const std::uint64_t epoch = bench.sensor()->sensor_epoch;
  auto flatness = measure_flatness(bench, run.frames);
  if (!flatness) return fail(flatness.error());
  return use<flatness_of>(services, bench, use_flatness(epoch, std::move(*flatness)));
}

Result<MapReport> map_bench(Bench& bench, const MapRun& run) {
  const std::uint64_t epoch = bench.sensor()->sensor_epoch;
  auto map = measure_map(bench, run);
  if (!map) return fail(map.error());
  if (run.apply) {
    if (auto used = bench.use(use_flatness(epoch, flatness_of(*map))); !used) {
      return fail(used.error());
    }
    map->report.applied = true;
  }
  return map->report;
}

LutReport lut_of(const Services& services, const SensorSnapshot& now) {
  LutReport report{now.slm->hologram.lut, services.config.slm.lut, std::nullopt};
  if (const auto& lut = now.slm->lut) {
    report.measured = LutMeasured{
        lut->t_taken_ns, lut->frames, lut->response, lut->table, sha256_of(services.library, *lut),
        {*lut->origin}};
  }
  return report;
}

Result<Json> linearise(const Services& services, Bench& bench, const LutRun& run) {
  auto lut = measure_lut(bench, run);
  if (!lut) return fail(lut.error());
  return use<lut_of>(services, bench, use_lut(std::move(*lut)));
}

void run_lut(Services& services, const LutRun& params, const Reply<JobNumber>& reply) {
  if (services.config.modulator != Modulator::dmd) {
    return run<kLutRun, linearise>(services, params, reply);
  }
  reply(Error{Errc::refused, "",
              "a DMD has two levels, so there is no look-up table to measure; its hologram needs "
              "none"});
}

KnownRegistration known_registration(const Services& /*services*/, const SensorSnapshot& now) {
  return {now.registration};
}

Result<Json> register_camera(const Services& services, Bench& bench, const RegistrationRun& run) {
  const auto found = services.config.modulator == Modulator::fixed
                         ? measure_array(bench, run.frames)
                         : measure_registration(bench, run.frames);
  if (!found) return fail(found.error());
  const auto before = bench.sensor()->registration;
  auto result = use<known_registration>(services, bench, use_registration(*found));
  const auto now = bench.sensor()->registration;
  if (result && before && now && now->base_px == before->base_px &&
      now->px_per_cycle == before->px_per_cycle) {
    bench.publish_info("registration",
                       "the registration is confirmed: the same map was found again; reference and "
                       "calibration stay in use",
                       {{"t_taken_ns", now->t_taken_ns}, {"confirmed", true}});
  }
  return result;
}

constexpr double kUsualMisfit = 0.1;  ///< of plates in bright, steady light

Result<ArrayFitReport> fit_array(const Services& services, Bench& bench, const ArrayFit& run) {
  const std::uint64_t epoch = bench.sensor()->sensor_epoch;
  const auto fit = measure_plate(bench, run.frames);
  if (!fit) return fail(fit.error());
  if (auto used = bench.use(use_plate(epoch, fit->plate)); !used) return fail(used.error());
  if (fit->misfit > kUsualMisfit) {
    bench.warn(
        "array",
        fmt::format("the plates explain the image only with a misfit of {:.2f}, which is below "
                    "0.1 in good light: they may be wrong; look for dim or changing light, and for "
                    "a camera that sees the array mirrored or turned against "
                    "optics.px_per_cycle, then run array.fit again",
                    fit->misfit),
        {{"misfit", fit->misfit}});
  }
  const double um = services.config.array.pitch_um / bench.sensor()->sensor.lenslets.width_px;
  return ArrayFitReport{fit->plate.levels,
                        fit->plate.depth,
                        fit->depth_standard_error,
                        um * fit->plate.shift_px,
                        um * fit->shift_standard_error_px,
                        fit->misfit,
                        fit->spots};
}

SensorReport sensor_of(const Services& /*services*/, const SensorSnapshot& now) {
  return {{now.sensor, now.tracking},
          now.mode_operator,
          now.subapertures,
          now.modes_j,
          now.hologram_id};
}

/// Removes "sensor." and "tracking." from the error's field: the core reports configuration keys,
/// but clients use the names of params.
Error in_params(Error error) {
  for (const std::string_view section : {"sensor.", "tracking."}) {
    if (error.field.starts_with(section)) error.field.erase(0, section.size());
  }
  return error;
}

void change_sensor(Services& services, const SensorSet& change,
                   const Reply<SensorSetReport>& reply) {
  const auto done = [change, reply](const Result<SensorView>& applied) {
    if (!applied) return reply(in_params(applied.error()));
    const SensorSnapshot& now = **applied;
    reply(SensorSetReport{change, {now.sensor, now.tracking}, now.hologram_id});
  };
  services.keeper.edit(set_sensor(change), done);
}

ShowReport shown_pattern(const Services& /*services*/, const SensorSnapshot& now) {
  return {now.pattern, now.hologram_id};
}

void show(Services& services, const SlmShow& what, const Reply<ShowReport>& reply) {
  edit<shown_pattern>(services, show_pattern(what.pattern), reply);
}

void present(Services& services, const SlmPresent& params, std::string picture,
             const Reply<PresentReport>& reply) {
  services.presentations.present(params, std::move(picture), reply);
}

Result<SettleReport> settle(const Services& services, Bench& bench, const SettleRun& run) {
  const auto time = measure_settle(bench, run);
  if (!time) return fail(time.error());
  return SettleReport{*time, run.repetitions, services.slm.snapshot().settings.settle_ms};
}

void list_outputs(Services& services, const Reply<OutputList>& reply) {
  services.slm.list_outputs([reply](const Result<std::vector<DisplayOutput>>& outputs) {
    if (!outputs) return reply(outputs.error());
    reply(OutputList{*outputs});
  });
}

void set_slm(Services& services, const SlmSet& change, const Reply<SlmSettings>& reply) {
  services.slm.change(change, reply);
}

void verify(Services& services, const Reply<VerifyReport>& reply) {
  services.slm.verify(reply);
}

constexpr std::array kSensorRows{
    row<kAberrationGet, get<aberration_of>>(Role::read, Request::read),
    row<kAberrationSequence, show_sequence>(Role::control, Request::show_pattern),
    row<kAberrationSet, introduce>(Role::control, Request::set_aberration),
    row<kAberrationClear, introduce_none>(Role::control, Request::set_aberration),
    row<kCalibrationRun, run<kCalibrationRun, calibrate, check_shows_one_sensor>>(
        Role::control, Request::run_hologram_job),
    row<kCalibrationSet, give>(Role::control, Request::set_measured),
    row<kCalibrationGet, get<calibration_of>>(Role::read, Request::read),
    row<kCalibrationClear, clear<calibration_of, forget_calibration>>(Role::control,
                                                                      Request::set_measured),
    row<kCorrectionGet, get<correction_of>>(Role::read, Request::read),
    row<kCorrectionSet, correct>(Role::control, Request::set_correction),
    row<kCorrectionClear, correct_nothing>(Role::control, Request::set_correction),
    row<kFlatnessRun, run<kFlatnessRun, flatten>>(Role::control, Request::run_hologram_job),
    row<kFlatnessGet, get<flatness_of>>(Role::read, Request::read),
    row<kFlatnessClear, clear<flatness_of, forget_flatness>>(Role::control, Request::set_measured),
    row<kFocusRun, run<kFocusRun, measure_focus>>(Role::control, Request::run_hologram_job),
    row<kLutRun, run_lut>(Role::control, Request::run_hologram_job),
    row<kLutGet, get<lut_of>>(Role::read, Request::read),
    row<kLutClear, clear<lut_of, forget_lut>>(Role::control, Request::set_measured),
    row<kArrayFit, run<kArrayFit, fit_array, can_fit_array>>(Role::control, Request::run_job),
    row<kMapRun, run<kMapRun, map_bench>>(Role::control, Request::run_hologram_job),
    row<kRegistrationRun, run<kRegistrationRun, register_camera>>(Role::control, Request::run_job),
    row<kRegistrationGet, get<known_registration>>(Role::read, Request::read),
    row<kRegistrationClear, clear<known_registration, forget_registration>>(Role::control,
                                                                            Request::set_measured),
    row<kSensorGet, get<sensor_of>>(Role::read, Request::read),
    row<kSensorSet, change_sensor>(Role::control, Request::set_sensor),
    row<kSlmOutputs, list_outputs>(Role::read, Request::read),
    row<kSlmPresent, present>(Role::control, Request::act),
    row<kSlmSet, set_slm>(Role::control, Request::set_devices),
    row<kSlmShow, show>(Role::control, Request::show_pattern),
    row<kSlmSettle, run<kSlmSettle, settle>>(Role::control, Request::run_hologram_job),
    row<kSlmVerify, verify>(Role::read, Request::read),
};

}  // namespace

std::span<const MethodRow> sensor_methods() {
  return kSensorRows;
}

}  // namespace ovws
