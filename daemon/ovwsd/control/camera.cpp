#include "daemon/ovwsd/control/methods.hpp"
#include "proto/tables/set.hpp"

namespace ovws {
namespace {

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  const CameraSnapshot camera = services.camera.snapshot();
  reply(to_json(CameraReport{camera.info, camera.settings, camera.limits}));
}

void set(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto change = CameraSet::decode(params);
  if (!change) return reply(failed(change.error()));
  if (change->gives(&CameraSettings::pixel_format)) {
    const auto suits = services.instrument.can_measure(change->applied_to({}).pixel_format);
    if (!suits) return reply(failed(suits.error()));
  }
  services.camera.change(
      *change, [&services, given = change->given(), reply](Result<CameraSnapshot> applied) {
        if (!applied) return reply(failed(applied.error()));
        services.instrument.after_changes([given, reply, camera = *applied] {
          reply(to_json(CameraSetReport{given, camera.settings, camera.limits}));
        });
      });
}

constexpr std::array<Method, 2> kMethods{{
    {"camera.get", Role::read, Action::read, get},
    {"camera.set", Role::control, Action::set_camera, set, decodes<CameraSet>},
}};

}  // namespace

std::span<const Method> camera_methods() {
  return kMethods;
}

}  // namespace ovws
