/// Methods refine.*: settings of the maximum-likelihood refinement, which runs beside the fast
/// estimate.
#include "proto/tables/refine.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/refine/live_refiner.hpp"
#include "proto/tables/set.hpp"

namespace ovws {
namespace {

PixelFormat camera_format(const Services& services) {
  return services.camera.snapshot().settings.pixel_format;
}

void get(Services& services, Reply<RefineReport> reply) {
  reply(RefineReport{in_format(services.refiner.settings(), camera_format(services))});
}

void set(Services& services, const RefineSet& change, Reply<RefineSetReport> reply) {
  const auto applied = services.refiner.change(change, camera_format(services));
  if (!applied) return reply(applied.error());
  reply(RefineSetReport{change, {*applied}});
}

constexpr std::array kRows{
    row<kRefineGet, get>(Role::read, Action::read),
    row<kRefineSet, set>(Role::control, Action::set_refine),
};

}  // namespace

std::span<const MethodRow> refine_methods() {
  return kRows;
}

}  // namespace ovws
