/// registration.* and calibration.*: what the bench measures of itself.
#include "daemon/ovwsd/procedures/calibration.hpp"
#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/procedures/registration.hpp"
#include "proto/tables/calibration.hpp"
#include "proto/tables/job.hpp"

namespace ovws {
namespace {

void start(Services& services, const char* kind, Procedure procedure, const RpcReply& reply) {
  services.procedures.start(kind, std::move(procedure), [reply](Result<int> job) {
    if (!job) return reply(failed(job.error()));
    reply(to_json(JobNumber{*job}));
  });
}

void run_registration(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto run = decode<RegistrationRun>(params);
  if (!run) return reply(failed(run.error()));
  const SlmGeometry slm = services.config.slm.geometry;
  start(
      services, "registration.run",
      [slm, frames = run->frames](Bench& bench) -> Result<nlohmann::json> {
        const auto found = measure_registration(bench, slm, frames);
        if (!found) return fail(found.error());
        if (auto used = bench.use_registration(*found); !used) return fail(used.error());
        return to_json(KnownRegistration{*found});
      },
      reply);
}

void get_registration(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(to_json(KnownRegistration{services.instrument.snapshot().registration}));
}

void clear_registration(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  services.instrument.clear_registration([reply](Result<SensorSnapshot> cleared) {
    if (!cleared) return reply(failed(cleared.error()));
    reply(to_json(KnownRegistration{cleared->registration}));
  });
}

nlohmann::json calibration_of(const SensorSnapshot& sensor) {
  if (!sensor.calibration) return to_json(KnownCalibration{});
  const Calibration& c = *sensor.calibration;
  const bool in_force = sensor.mode_operator.in_force == OperatorKind::measured;
  return to_json(
      KnownCalibration{in_force, CalibrationReport{c.amplitude_waves, c.frames, c.t_taken_ns,
                                                   c.matrix, c.comparison, c.sha256, *c.origin}});
}

void run_calibration(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto run = decode<CalibrationRun>(params);
  if (!run) return reply(failed(run.error()));
  if (services.instrument.snapshot().pattern != HologramKind::sensor) {
    return reply(failed({Errc::refused, "",
                         "the SLM does not show the sensor: call slm.show with \"sensor\" first"}));
  }
  const SlmGeometry slm = services.config.slm.geometry;
  start(
      services, "calibration.run",
      [slm, run = *run](Bench& bench) -> Result<nlohmann::json> {
        const std::uint64_t epoch = bench.sensor().sensor_epoch;
        auto measured = measure_calibration(bench, slm, run);
        if (!measured) return fail(measured.error());
        if (auto used = bench.use_calibration(epoch, std::move(*measured)); !used) {
          return fail(used.error());
        }
        return calibration_of(bench.sensor());
      },
      reply);
}

void get_calibration(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(calibration_of(services.instrument.snapshot()));
}

void clear_calibration(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  services.instrument.clear_calibration([reply](Result<SensorSnapshot> cleared) {
    if (!cleared) return reply(failed(cleared.error()));
    reply(calibration_of(*cleared));
  });
}

constexpr std::array<Method, 6> kMethods{{
    {"registration.run", Role::control, Action::start_job, run_registration,
     decodes<RegistrationRun>},
    {"registration.get", Role::read, Action::read, get_registration},
    {"registration.clear", Role::control, Action::clear_reference, clear_registration},
    {"calibration.run", Role::control, Action::start_job, run_calibration, decodes<CalibrationRun>},
    {"calibration.get", Role::read, Action::read, get_calibration},
    {"calibration.clear", Role::control, Action::clear_reference, clear_calibration},
}};

}  // namespace

std::span<const Method> calibration_methods() {
  return kMethods;
}

}  // namespace ovws
