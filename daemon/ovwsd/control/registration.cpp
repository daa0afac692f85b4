/// Methods registration.*: where the camera stands and how it is oriented.
#include "daemon/ovwsd/procedures/registration.hpp"
#include "config/config.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/reference.hpp"

namespace ovws {
namespace {

KnownRegistration report_of(const SensorSnapshot& now) {
  return {now.registration};
}

void run(Services& services, const RegistrationRun& run, Reply<JobNumber> reply) {
  services.procedures.start(
      kRegistrationRun.name,
      [slm = services.config.slm.geometry, run](Bench& bench) -> Result<Json> {
        const auto found = measure_registration(bench, slm, run.frames);
        if (!found) return fail(found.error());
        if (auto used = bench.use(use_registration(*found)); !used) return fail(used.error());
        return to_json(KnownRegistration{*found});
      },
      with_job_number(reply));
}

void get(Services& services, Reply<KnownRegistration> reply) {
  reply(report_of(*services.keeper.snapshot()));
}

void clear(Services& services, Reply<KnownRegistration> reply) {
  services.keeper.edit(Hold::unheld(), forget_registration(), with_report(reply, report_of));
}

constexpr std::array kRows{
    row<kRegistrationRun, run>(Role::control, Action::start_job),
    row<kRegistrationGet, get>(Role::read, Action::read),
    row<kRegistrationClear, clear>(Role::control, Action::clear_reference),
};

}  // namespace

std::span<const MethodRow> registration_methods() {
  return kRows;
}

}  // namespace ovws
