/// Methods sensor.*, aberration.* and slm.show: changes of the hologram.
#include "daemon/ovwsd/control/methods.hpp"

namespace ovws {
namespace {

void get(Services& services, Reply<SensorReport> reply) {
  const SensorView sensor = services.keeper.snapshot();
  reply(SensorReport{{sensor->sensor, sensor->tracking},
                     sensor->templates,
                     sensor->mode_operator,
                     sensor->subapertures,
                     sensor->modes_j,
                     sensor->hologram_id});
}

/// Removes "sensor." and "tracking." from the error's field: the core names configuration keys,
/// clients know params.
Error in_params(Error error) {
  for (const std::string_view section : {"sensor.", "tracking."}) {
    if (error.field.starts_with(section)) error.field.erase(0, section.size());
  }
  return error;
}

void set(Services& services, const SensorSet& change, Reply<SensorSetReport> reply) {
  const auto done = [change, reply](const Result<SensorView>& applied) {
    if (!applied) return reply(in_params(applied.error()));
    const SensorSnapshot& now = **applied;
    reply(SensorSetReport{change, {now.sensor, now.tracking}, now.hologram_id});
  };
  services.keeper.edit(Hold::unheld(), set_sensor(change), done);
}

auto with_aberration(Reply<ModesReport> reply) {
  return [reply = std::move(reply)](const Result<SensorView>& applied) {
    if (!applied) return reply(applied.error());
    reply(ModesReport((*applied)->aberration, (*applied)->hologram_id));
  };
}

void get_aberration(Services& services, Reply<ModesReport> reply) {
  with_aberration(reply)(services.keeper.snapshot());
}

// Allowed with the loop closed, too: the loop then corrects the aberration.
void introduce(Services& services, const ModesSet& set, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::of_loop(), set_aberration(set.modes), with_aberration(reply));
}

void clear_aberration(Services& services, Reply<ModesReport> reply) {
  services.keeper.edit(Hold::of_loop(), set_aberration({}), with_aberration(reply));
}

void show(Services& services, const SlmShow& what, Reply<ShowReport> reply) {
  services.keeper.edit(Hold::unheld(), show_pattern(what.pattern.kind),
                       [reply](const Result<SensorView>& applied) {
                         if (!applied) return reply(applied.error());
                         reply(ShowReport{(*applied)->pattern, (*applied)->hologram_id});
                       });
}

constexpr std::array kRows{
    row<kSensorGet, get>(Role::read, Action::read),
    row<kSensorSet, set>(Role::control, Action::set_sensor),
    row<kAberrationGet, get_aberration>(Role::read, Action::read),
    row<kAberrationSet, introduce>(Role::control, Action::set_aberration),
    row<kAberrationClear, clear_aberration>(Role::control, Action::set_aberration),
    row<kSlmShow, show>(Role::control, Action::show_pattern),
};

}  // namespace

std::span<const MethodRow> sensor_methods() {
  return kRows;
}

}  // namespace ovws
