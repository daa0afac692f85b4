/// Methods lut.*: the measured look-up table of the SLM.
#include "daemon/ovwsd/procedures/lut.hpp"
#include "config/config.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/slm.hpp"

namespace ovws {
namespace {

LutReport report_of(const Services& services, const SensorSnapshot& now) {
  LutReport report{now.slm->hologram.lut, services.config.slm.lut, std::nullopt};
  if (const auto& lut = now.slm->lut) {
    report.measured = LutMeasured{lut->t_taken_ns, lut->frames, lut->response,
                                  lut->table,      lut->sha256, {lut->origin}};
  }
  return report;
}

void run(Services& services, const LutRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kLutRun.name,
      [&services, run](Bench& bench) -> Result<Json> {
        auto lut = measure_lut(bench, services.config.slm.geometry, run);
        if (!lut) return fail(lut.error());
        if (auto used = bench.use(use_lut(std::move(*lut))); !used) return fail(used.error());
        return to_json(report_of(services, *bench.sensor()));
      },
      with_job_number(reply));
}

void get(Services& services, Reply<LutReport> reply) {
  reply(report_of(services, *services.keeper.snapshot()));
}

void clear(Services& services, Reply<LutReport> reply) {
  services.keeper.edit(Hold::unheld(), forget_lut(),
                       with_report(reply, [&services](const SensorSnapshot& now) {
                         return report_of(services, now);
                       }));
}

constexpr std::array kRows{
    row<kLutRun, run>(Role::control, Action::start_job),
    row<kLutGet, get>(Role::read, Action::read),
    row<kLutClear, clear>(Role::control, Action::clear_reference),
};

}  // namespace

std::span<const MethodRow> lut_methods() {
  return kRows;
}

}  // namespace ovws
