/// sensor.*: which subapertures there are and how they are tracked, and advice on them.
#include "daemon/ovws/design/advise.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/sensor_handlers.hpp"
#include "proto/tables/advice.hpp"
#include "proto/tables/sensor.hpp"
#include "proto/tables/set.hpp"

namespace ovws {
namespace {

SensorReport sensor_of(const Services& /*services*/, const SensorSnapshot& now) {
  return {{now.sensor, now.tracking}, now.templates, now.mode_operator,
          now.subapertures,           now.modes_j,   now.hologram_id};
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

Json report_of(const design::AdviceList& list) {
  SensorAdvice report;
  for (const design::Advice& one : list.best_first) {
    const bool by_time = one.limited_by == design::ExposureLimit::time;
    const SensorConfig& sensor = one.config.sensor;
    report.best_first.push_back({one.subapertures_across, one.subapertures, one.charge,
                                 sensor.grooves, sensor.spacing, one.exposure_us, one.peak_e,
                                 one.error_waves, one.worst_waves,
                                 by_time ? "exposure time" : "full well"});
  }
  for (const design::Unfit& one : list.unfit) {
    report.unfit.push_back({one.subapertures_across, one.charge, one.reason});
  }
  return to_json(report);
}

void advise(Services& services, const SensorAdvise& wanted, const Reply<JobNumber>& reply) {
  Config config = services.config;
  if (config.modulator == Modulator::fixed) {
    return reply(Error{Errc::refused, "", "the lenslets of a fixed array cannot be chosen"});
  }
  config.camera.settings = services.camera.snapshot().settings;
  design::Bench bench = design::bench_of(config);
  bench.modes = wanted.modes;
  const double interval_us = 1e6 / config.camera.settings.frame_rate_hz;
  const design::Light light{wanted.photo_electrons_per_s, wanted.full_well_e, wanted.read_noise_e,
                            wanted.longest_us.value_or(interval_us)};
  start_job(services, kSensorAdvise.name, reply, [config, bench, light](Bench& on) -> Result<Json> {
    const auto list = design::advise(bench, light, config, [&on] { return on.stopped(); });
    if (on.stopped()) return fail(Errc::refused, "", "the job was stopped");
    return report_of(list);
  });
}

constexpr std::array kLayoutRows{
    row<kSensorAdvise, advise>(Role::control, Request::watch),
    row<kSensorGet, get<sensor_of>>(Role::read, Request::read),
    row<kSensorSet, change_sensor>(Role::control, Request::set_sensor),
};

}  // namespace

std::span<const MethodRow> layout_methods() {
  return kLayoutRows;
}

}  // namespace ovws
