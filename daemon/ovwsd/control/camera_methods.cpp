/// Methods of the camera.
#include "config/config.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/camera/camera_finder.hpp"
#include "daemon/ovwsd/control/sensor_handlers.hpp"
#include "daemon/ovwsd/frames/frame_grabs.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"
#include "daemon/ovwsd/procedures/procedures.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "proto/tables/camera.hpp"
#include "proto/tables/devices.hpp"
#include "proto/tables/picture.hpp"
#include "proto/tables/set.hpp"

namespace ovws {
namespace {

void get_camera(Services& services, const Reply<CameraReport>& reply) {
  const CameraSnapshot camera = services.camera.snapshot();
  reply(CameraReport{camera.info, camera.settings, camera.limits});
}

void set_camera(Services& services, const CameraSet& change, const Reply<CameraSetReport>& reply) {
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

void grab(Services& services, const CameraGrab& params, const Reply<GrabReport>& reply) {
  services.grabs.grab(params, [reply](const Result<GrabReport>& grabbed, auto pixels) {
    if (!grabbed) return reply(grabbed.error());
    reply(*grabbed, std::move(pixels));
  });
}

void list_cameras(Services& services, const Reply<CameraList>& reply) {
  services.finder.list(
      [reply](const std::vector<CameraListing>& listed) { reply(CameraList{listed}); });
}

void select_camera(Services& services, const CameraSelect& params,
                   const Reply<CameraReport>& reply) {
  if (services.config.camera.driver == kReplayDriver && !params.id.starts_with('/')) {
    return reply(Error{Errc::invalid, "id", "must be the absolute path of a recording"});
  }
  const auto select = [&services, params](const Reply<CameraReport>& to) {
    CameraSet clamped;  // the present settings, as far as the other camera has them
    clamped.set_clamp(true);
    services.camera.select(params.id, clamped, params.wait,
                           [&services, to](const Result<CameraSnapshot>& selected) {
                             if (!selected) return to(selected.error());
                             services.keeper.after_changes([to, camera = *selected] {
                               to(CameraReport{camera.info, camera.settings, camera.limits});
                             });
                           });
  };
  if (params.wait) return select(reply);
  reply.end_lease();  // a discovery may not answer for minutes
  // A typing error does not disconnect the camera.
  services.finder.find(params.id, [&services, select, reply](const Result<void>& found) {
    if (!found) return reply(found.error());
    const auto lease = services.leases.take(Request::set_devices);
    if (!lease) return reply(lease.error());
    select(reply.with(*lease));
  });
}

constexpr std::array kCameraRows{
    row<kCameraAutoExposure, run<kCameraAutoExposure, set_exposure, check_no_sequence>>(
        Role::control, Request::run_job),
    row<kCameraGet, get_camera>(Role::read, Request::read),
    row<kCameraGrab, grab>(Role::read, Request::grab),
    row<kCameraList, list_cameras>(Role::read, Request::read),
    // Another camera or output is like a reload: no job and no closed loop may depend on it.
    row<kCameraSelect, select_camera>(Role::control, Request::set_devices),
    row<kCameraSet, set_camera>(Role::control, Request::set_camera),
};

}  // namespace

std::span<const MethodRow> camera_methods() {
  return kCameraRows;
}

}  // namespace ovws
