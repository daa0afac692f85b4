/// registration.* and calibration.*: what the bench measures of itself.
#include "daemon/ovwsd/procedures/calibration.hpp"
#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/procedures/registration.hpp"

namespace ovws {
namespace {

void run_registration(Services& services, const RegistrationRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kRegistrationRun.name,
      [slm = services.config.slm.geometry, run](Bench& bench) -> Result<Json> {
        const auto found = measure_registration(bench, slm, run.frames);
        if (!found) return fail(found.error());
        if (auto used = bench.use_registration(*found); !used) return fail(used.error());
        return to_json(KnownRegistration{*found});
      },
      with_number(reply));
}

void get_registration(Services& services, Reply<KnownRegistration> reply) {
  reply(KnownRegistration{services.instrument.snapshot().registration});
}

void clear_registration(Services& services, Reply<KnownRegistration> reply) {
  services.instrument.clear_registration([reply](Result<SensorSnapshot> cleared) {
    if (!cleared) return reply(cleared.error());
    reply(KnownRegistration{cleared->registration});
  });
}

KnownCalibration calibration_of(const SensorSnapshot& sensor) {
  if (!sensor.calibration) return {};
  const Calibration& c = *sensor.calibration;
  return {sensor.mode_operator.in_force == OperatorKind::measured,
          CalibrationReport{c.amplitude_waves,
                            c.frames,
                            c.t_taken_ns,
                            c.matrix,
                            c.comparison,
                            c.sha256,
                            {*c.origin}}};
}

void run_calibration(Services& services, const CalibrationRun& run, Reply<JobNumber> reply) {
  if (services.instrument.snapshot().pattern != HologramKind::sensor) {
    return reply(Error{Errc::refused, "",
                       "the SLM does not show the sensor: call slm.show with \"sensor\" first"});
  }
  services.procedures.start(
      kCalibrationRun.name,
      [slm = services.config.slm.geometry, run](Bench& bench) -> Result<Json> {
        const std::uint64_t epoch = bench.sensor().sensor_epoch;
        auto measured = measure_calibration(bench, slm, run);
        if (!measured) return fail(measured.error());
        if (auto used = bench.use_calibration(epoch, std::move(*measured)); !used) {
          return fail(used.error());
        }
        return to_json(calibration_of(bench.sensor()));
      },
      with_number(reply));
}

void get_calibration(Services& services, Reply<KnownCalibration> reply) {
  reply(calibration_of(services.instrument.snapshot()));
}

void clear_calibration(Services& services, Reply<KnownCalibration> reply) {
  services.instrument.clear_calibration([reply](Result<SensorSnapshot> cleared) {
    if (!cleared) return reply(cleared.error());
    reply(calibration_of(*cleared));
  });
}

constexpr std::array kRows{
    row<kRegistrationRun, run_registration>(Role::control, Action::start_job),
    row<kRegistrationGet, get_registration>(Role::read, Action::read),
    row<kRegistrationClear, clear_registration>(Role::control, Action::clear_reference),
    row<kCalibrationRun, run_calibration>(Role::control, Action::start_job),
    row<kCalibrationGet, get_calibration>(Role::read, Action::read),
    row<kCalibrationClear, clear_calibration>(Role::control, Action::clear_reference),
};

}  // namespace

std::span<const MethodRow> calibration_methods() {
  return kRows;
}

}  // namespace ovws
