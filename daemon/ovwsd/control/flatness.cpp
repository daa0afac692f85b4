/// Methods flatness.*: the measured phase error of the SLM.
#include "daemon/ovwsd/procedures/flatness.hpp"
#include "config/config.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/slm.hpp"

namespace ovws {
namespace {

FlatnessReport report_of(const Services& services, const SensorSnapshot& now) {
  FlatnessReport report{services.config.slm.flatness, std::nullopt};
  const auto& f = now.slm->flatness;
  if (!f) return report;
  report.measured =
      FlatnessMeasured{f->t_taken_ns,         f->frames, f->iterations, f->pupil_diameter_px, {},
                       f->residual_rms_waves, f->sha256, {f->origin}};
  for (std::size_t k = 0; k < f->modes.size(); ++k) {
    report.measured->modes.push_back(
        {f->modes[k].j, f->modes[k].waves, f->standard_error_waves[k]});
  }
  return report;
}

void run(Services& services, const FlatnessRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kFlatnessRun.name,
      [&services, run](Bench& bench) -> Result<Json> {
        const std::uint64_t epoch = bench.sensor()->sensor_epoch;
        auto flatness = measure_flatness(bench, services.config.slm.geometry, run.frames);
        if (!flatness) return fail(flatness.error());
        if (auto used = bench.use(use_flatness(epoch, std::move(*flatness))); !used) {
          return fail(used.error());
        }
        return to_json(report_of(services, *bench.sensor()));
      },
      with_job_number(reply));
}

void get(Services& services, Reply<FlatnessReport> reply) {
  reply(report_of(services, *services.keeper.snapshot()));
}

void clear(Services& services, Reply<FlatnessReport> reply) {
  services.keeper.edit(Hold::unheld(), forget_flatness(),
                       with_report(reply, [&services](const SensorSnapshot& now) {
                         return report_of(services, now);
                       }));
}

constexpr std::array kRows{
    row<kFlatnessRun, run>(Role::control, Action::start_job),
    row<kFlatnessGet, get>(Role::read, Action::read),
    row<kFlatnessClear, clear>(Role::control, Action::clear_reference),
};

}  // namespace

std::span<const MethodRow> flatness_methods() {
  return kRows;
}

}  // namespace ovws
