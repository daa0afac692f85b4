/// record.*: what the pipeline measures, into a file.
#include "proto/tables/record.hpp"
#include "daemon/ovwsd/control/methods.hpp"
#include "daemon/ovwsd/settings/config_in_use.hpp"

namespace ovws {
namespace {

Recorder::Done answer_with(RpcReply reply) {
  return [reply = std::move(reply)](const Result<RecordReport>& now) {
    if (!now) return reply(failed(now.error()));
    reply(to_json(*now));
  };
}

void start(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto asked = decode<RecordStart>(params);
  if (!asked) return reply(failed(asked.error()));
  const Config in_use = config_in_use(services.config, services.loaded.get(), services.camera,
                                      services.instrument, services.refiner);
  services.recorder.start({*asked, dump_config(in_use), in_use.camera.settings,
                           services.camera.snapshot().info, "ovwsd " OVWS_VERSION},
                          answer_with(std::move(reply)));
}

void stop(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  services.recorder.stop(answer_with(std::move(reply)));
}

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(to_json(services.recorder.report()));
}

constexpr std::array<Method, 3> kMethods{{
    {"record.start", Role::control, Action::record, start, decodes<RecordStart>},
    {"record.stop", Role::control, Action::record, stop},
    {"record.get", Role::read, Action::read, get},
}};

}  // namespace

std::span<const Method> record_methods() {
  return kMethods;
}

}  // namespace ovws
