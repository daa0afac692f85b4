/// Methods aberration.*: the modes that the hologram introduces.
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {
namespace {

ModesReport report_of(const SensorSnapshot& now) {
  return {now.aberration, now.hologram_id};
}

void get(Services& services, Reply<ModesReport> reply) {
  reply(report_of(*services.keeper.snapshot()));
}

// Allowed with the loop closed, too: the loop then corrects the aberration.
void set(Services& services, const ModesSet& change, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::of_loop(), set_aberration(change.modes),
                       with_report(reply, report_of));
}

void clear(Services& services, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::of_loop(), set_aberration({}), with_report(reply, report_of));
}

constexpr std::array kRows{
    row<kAberrationGet, get>(Role::read, Action::read),
    row<kAberrationSet, set>(Role::control, Action::set_aberration),
    row<kAberrationClear, clear>(Role::control, Action::set_aberration),
};

}  // namespace

std::span<const MethodRow> aberration_methods() {
  return kRows;
}

}  // namespace ovws
