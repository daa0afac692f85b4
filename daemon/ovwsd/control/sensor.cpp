/// Methods sensor.*: the sensor's layout and how its spots are tracked.
#include "proto/tables/sensor.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/set.hpp"

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

constexpr std::array kRows{
    row<kSensorGet, get>(Role::read, Action::read),
    row<kSensorSet, set>(Role::control, Action::set_sensor),
};

}  // namespace

std::span<const MethodRow> sensor_methods() {
  return kRows;
}

}  // namespace ovws
