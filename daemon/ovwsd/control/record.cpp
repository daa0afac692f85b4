/// Methods record.*: recordings of all measured frames in a file.
#include "proto/tables/record.hpp"
#include "daemon/ovwsd/control/method_table.hpp"
#include "daemon/ovwsd/record/recorder.hpp"
#include "daemon/ovwsd/settings/config_in_use.hpp"

namespace ovws {
namespace {

void start(Services& services, const RecordStart& asked, Reply<RecordReport> reply) {
  const Config in_use = config_in_use(services.config, services.loaded.get(), services.camera,
                                      services.keeper, services.refiner);
  services.recorder.start({asked, dump_config(in_use), in_use.camera.settings,
                           services.camera.snapshot().info, "ovwsd " OVWS_VERSION},
                          reply);
}

void stop(Services& services, Reply<RecordReport> reply) {
  services.recorder.stop(reply);
}

void get(Services& services, Reply<RecordReport> reply) {
  reply(services.recorder.report());
}

constexpr std::array kRows{
    row<kRecordStart, start>(Role::control, Action::record),
    row<kRecordStop, stop>(Role::control, Action::record),
    row<kRecordGet, get>(Role::read, Action::read),
};

}  // namespace

std::span<const MethodRow> record_methods() {
  return kRows;
}

}  // namespace ovws
