/// refine.*: the refinement of frames beside the fast estimate.
#include "daemon/ovwsd/control/methods.hpp"
#include "proto/tables/set.hpp"

namespace ovws {
namespace {

PixelFormat camera_format(const Services& services) {
  return services.camera.snapshot().settings.pixel_format;
}

void get(Services& services, const nlohmann::json& /*params*/, RpcReply reply) {
  reply(to_json(RefineReport{in_format(services.refiner.settings(), camera_format(services))}));
}

void set(Services& services, const nlohmann::json& params, RpcReply reply) {
  const auto change = RefineSet::decode(params);
  if (!change) return reply(failed(change.error()));
  const auto applied = services.refiner.change(*change, camera_format(services));
  if (!applied) return reply(failed(applied.error()));
  reply(to_json(RefineSetReport{change->given(), {*applied}}));
}

constexpr std::array<Method, 2> kMethods{{
    {"refine.get", Role::read, Action::read, get},
    {"refine.set", Role::control, Action::set_refine, set, decodes<RefineSet>},
}};

}  // namespace

std::span<const Method> refine_methods() {
  return kMethods;
}

}  // namespace ovws
