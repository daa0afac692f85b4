/// Methods slm.*: what the SLM shows, and how fast.
#include "proto/tables/slm.hpp"
#include "config/config.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/procedures/settle.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/slm/slm_loop.hpp"

namespace ovws {
namespace {

void show(Services& services, const SlmShow& what, Reply<ShowReport> reply) {
  services.keeper.edit(Hold::unheld(), show_pattern(what.pattern),
                       [reply](const Result<SensorView>& applied) {
                         if (!applied) return reply(applied.error());
                         reply(ShowReport{(*applied)->pattern, (*applied)->hologram_id});
                       });
}

void settle(Services& services, const SettleRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kSlmSettle.name,
      [&services, run](Bench& bench) -> Result<Json> {
        const auto time = measure_settle(bench, services.config.slm.geometry, run);
        if (!time) return fail(time.error());
        return to_json(SettleReport{*time, run.repetitions, services.config.slm.settle_ms});
      },
      with_job_number(reply));
}

void verify(Services& services, Reply<VerifyReport> reply) {
  services.slm.verify([reply](Result<SlmVerdict> seen) {
    if (!seen) return reply(seen.error());
    reply(VerifyReport{seen->hologram_id, seen->crc32, seen->crc32_shown, seen->differing_pixels});
  });
}

constexpr std::array kRows{
    row<kSlmShow, show>(Role::control, Action::show_pattern),
    row<kSlmSettle, settle>(Role::control, Action::start_job),
    row<kSlmVerify, verify>(Role::read, Action::read),
};

}  // namespace

std::span<const MethodRow> slm_methods() {
  return kRows;
}

}  // namespace ovws
