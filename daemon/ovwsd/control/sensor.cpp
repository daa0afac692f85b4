/// sensor.*, aberration.* and slm.show: all that changes the hologram.
#include "daemon/ovwsd/control/methods.hpp"
#include "proto/tables/set.hpp"
#include "proto/tables/slm.hpp"

namespace ovws {
namespace {

SensorReport report_of(const SensorSnapshot& sensor) {
  return {{sensor.sensor, sensor.tracking},
          sensor.templates,
          sensor.mode_operator,
          sensor.subapertures,
          sensor.modes_j,
          sensor.hologram_id};
}

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(to_json(report_of(services.instrument.snapshot())));
}

/// The core names settings as the configuration does, a client as the method's params do.
Error in_params(Error error) {
  for (const std::string_view room : {"sensor.", "tracking."}) {
    if (error.field.starts_with(room)) error.field.erase(0, room.size());
  }
  return error;
}

void set(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto change = SensorSet::decode(params);
  if (!change) return reply(failed(change.error()));
  services.instrument.change_sensor(
      *change, [given = change->given(), reply](Result<SensorSnapshot> applied) {
        if (!applied) return reply(failed(in_params(applied.error())));
        reply(to_json(
            SensorSetReport{given, {applied->sensor, applied->tracking}, applied->hologram_id}));
      });
}

void answer_aberration(const RpcReply& reply, const Result<SensorSnapshot>& applied) {
  if (!applied) return reply(failed(applied.error()));
  reply(to_json(ModesReport(applied->aberration, applied->hologram_id)));
}

void get_aberration(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  answer_aberration(reply, services.instrument.snapshot());
}

void set_aberration(Services& services, const nlohmann::json& params, RpcReply reply) {
  auto modes = ModesSet::decode(params);
  if (!modes) return reply(failed(modes.error()));
  services.instrument.set_aberration(
      std::move(modes->modes),
      [reply](Result<SensorSnapshot> applied) { answer_aberration(reply, applied); });
}

void clear_aberration(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  services.instrument.set_aberration(
      {}, [reply](Result<SensorSnapshot> applied) { answer_aberration(reply, applied); });
}

void show(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto pattern = decode<SlmShow>(params);
  if (!pattern) return reply(failed(pattern.error()));
  services.instrument.show(pattern->pattern.kind, [reply](Result<SensorSnapshot> applied) {
    if (!applied) return reply(failed(applied.error()));
    reply(to_json(ShowReport{applied->pattern, applied->hologram_id}));
  });
}

constexpr std::array<Method, 6> kMethods{{
    {"sensor.get", Role::read, Action::read, get},
    {"sensor.set", Role::control, Action::set_sensor, set, decodes<SensorSet>},
    {"aberration.get", Role::read, Action::read, get_aberration},
    {"aberration.set", Role::control, Action::set_aberration, set_aberration, decodes<ModesSet>},
    {"aberration.clear", Role::control, Action::set_aberration, clear_aberration},
    {"slm.show", Role::control, Action::show_pattern, show, decodes<SlmShow>},
}};

}  // namespace

std::span<const Method> sensor_methods() {
  return kMethods;
}

}  // namespace ovws
