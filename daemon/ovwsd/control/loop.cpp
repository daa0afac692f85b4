/// loop.* and correction.*: what is subtracted from the hologram, by the loop or by a person.
#include "proto/tables/loop.hpp"
#include "daemon/ovwsd/control/methods.hpp"

namespace ovws {
namespace {

ClosedLoop::Done answer_with(RpcReply reply) {
  return [reply = std::move(reply)](const Result<LoopReport>& now) {
    if (!now) return reply(failed(now.error()));
    reply(to_json(*now));
  };
}

void close(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto settings = decode<LoopSettings>(params);
  if (!settings) return reply(failed(settings.error()));
  services.loop.close(*settings, answer_with(std::move(reply)));
}

void open(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto keep = decode<LoopOpen>(params);
  if (!keep) return reply(failed(keep.error()));
  services.loop.open(keep->keep, answer_with(std::move(reply)));
}

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(to_json(services.loop.report()));
}

void answer_correction(const RpcReply& reply, const Result<SensorSnapshot>& now) {
  if (!now) return reply(failed(now.error()));
  reply(to_json(ModesReport(now->correction, now->hologram_id)));
}

void get_correction(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  answer_correction(reply, services.instrument.snapshot());
}

void set_correction(Services& services, const nlohmann::json& params, RpcReply reply) {
  auto modes = ModesSet::decode(params);
  if (!modes) return reply(failed(modes.error()));
  services.instrument.set_correction(std::move(modes->modes), [reply](Result<SensorSnapshot> now) {
    answer_correction(reply, now);
  });
}

void clear_correction(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  services.instrument.set_correction(
      {}, [reply](Result<SensorSnapshot> now) { answer_correction(reply, now); });
}

constexpr std::array<Method, 6> kMethods{{
    {"loop.close", Role::control, Action::close_loop, close, decodes<LoopSettings>},
    {"loop.open", Role::control, Action::open_loop, open, decodes<LoopOpen>},
    {"loop.get", Role::read, Action::read, get},
    {"correction.get", Role::read, Action::read, get_correction},
    {"correction.set", Role::control, Action::set_correction, set_correction, decodes<ModesSet>},
    {"correction.clear", Role::control, Action::set_correction, clear_correction},
}};

}  // namespace

std::span<const Method> loop_methods() {
  return kMethods;
}

}  // namespace ovws
