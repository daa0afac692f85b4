/// Methods loop.* and correction.*: the closed loop, and the modes that it or a client corrects.
#include "daemon/ovwsd/control/methods.hpp"

namespace ovws {
namespace {

void close(Services& services, const LoopSettings& settings, Reply<LoopReport> reply) {
  services.loop.close(settings, reply);
}

void open(Services& services, const LoopOpen& how, Reply<LoopReport> reply) {
  services.loop.open(how.keep, reply);
}

void get(Services& services, Reply<LoopReport> reply) {
  reply(services.loop.report());
}

auto with_correction(Reply<ModesReport> reply) {
  return [reply = std::move(reply)](const Result<SensorView>& now) {
    if (!now) return reply(now.error());
    reply(ModesReport((*now)->correction, (*now)->hologram_id));
  };
}

void get_correction(Services& services, Reply<ModesReport> reply) {
  with_correction(reply)(services.keeper.snapshot());
}

void correct(Services& services, const ModesSet& set, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::unheld(), set_correction(set.modes), with_correction(reply));
}

void clear_correction(Services& services, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::unheld(), set_correction({}), with_correction(reply));
}

constexpr std::array kRows{
    row<kLoopClose, close>(Role::control, Action::close_loop),
    row<kLoopOpen, open>(Role::control, Action::open_loop),
    row<kLoopGet, get>(Role::read, Action::read),
    row<kCorrectionGet, get_correction>(Role::read, Action::read),
    row<kCorrectionSet, correct>(Role::control, Action::set_correction),
    row<kCorrectionClear, clear_correction>(Role::control, Action::set_correction),
};

}  // namespace

std::span<const MethodRow> loop_methods() {
  return kRows;
}

}  // namespace ovws
