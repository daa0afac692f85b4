#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/set.hpp"

namespace ovws {
namespace {

void get(Services& services, Reply<CameraReport> reply) {
  const CameraSnapshot camera = services.camera.snapshot();
  reply(CameraReport{camera.info, camera.settings, camera.limits});
}

void set(Services& services, const CameraSet& change, Reply<CameraSetReport> reply) {
  if (change.gives(&CameraSettings::pixel_format)) {
    const auto suits = can_measure(*services.keeper.snapshot(), services.config.slm.geometry,
                                   change.applied_to({}).pixel_format);
    if (!suits) return reply(suits.error());
  }
  services.camera.change(change, [&services, change, reply](Result<CameraSnapshot> applied) {
    if (!applied) return reply(applied.error());
    services.keeper.after_changes([change, reply, camera = *applied] {
      reply(CameraSetReport{change, camera.settings, camera.limits});
    });
  });
}

constexpr std::array kRows{
    row<kCameraGet, get>(Role::read, Action::read),
    row<kCameraSet, set>(Role::control, Action::set_camera),
};

}  // namespace

std::span<const MethodRow> camera_methods() {
  return kRows;
}

}  // namespace ovws
