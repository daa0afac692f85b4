/// Methods correction.*: the modes that the closed loop or a client corrects.
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/modes.hpp"

namespace ovws {
namespace {

ModesReport report_of(const SensorSnapshot& now) {
  return {now.correction, now.hologram_id};
}

void get(Services& services, Reply<ModesReport> reply) {
  reply(report_of(*services.keeper.snapshot()));
}

void set(Services& services, const ModesSet& change, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::unheld(), set_correction(change.modes), with_report(reply, report_of));
}

void clear(Services& services, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::unheld(), set_correction({}), with_report(reply, report_of));
}

constexpr std::array kRows{
    row<kCorrectionGet, get>(Role::read, Action::read),
    row<kCorrectionSet, set>(Role::control, Action::set_correction),
    row<kCorrectionClear, clear>(Role::control, Action::set_correction),
};

}  // namespace

std::span<const MethodRow> correction_methods() {
  return kRows;
}

}  // namespace ovws
