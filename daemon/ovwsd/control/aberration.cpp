/// Methods aberration.*: the modes that the hologram introduces.
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {
namespace {

auto with_aberration(Reply<ModesReport> reply) {
  return [reply = std::move(reply)](const Result<SensorView>& applied) {
    if (!applied) return reply(applied.error());
    reply(ModesReport((*applied)->aberration, (*applied)->hologram_id));
  };
}

void get(Services& services, Reply<ModesReport> reply) {
  with_aberration(reply)(services.keeper.snapshot());
}

// Allowed with the loop closed, too: the loop then corrects the aberration.
void set(Services& services, const ModesSet& change, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::of_loop(), set_aberration(change.modes), with_aberration(reply));
}

void clear(Services& services, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::of_loop(), set_aberration({}), with_aberration(reply));
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
