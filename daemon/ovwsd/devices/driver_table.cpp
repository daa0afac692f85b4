#include "daemon/ovwsd/devices/driver_table.hpp"

#include <algorithm>
#include <array>

#include "daemon/ovwsd/devices/no_display.hpp"
#include "daemon/ovwsd/devices/sdl_config.hpp"
#include "daemon/ovwsd/threads/thread_plan.hpp"
#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/replay/replay_camera.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws {
namespace {

/// Priority of the camera's receive thread: below the threads of the frame path, because packets of
/// the next frame can wait in the socket.
constexpr int kReceivePriority =
    std::ranges::find(kThreadTable, ThreadRole::publish, &ThreadRow::role)->fifo_priority - 1;

template <class Config, class Port>
struct Row {
  const char* name;
  Result<std::unique_ptr<Port>> (*open)(const Config&);
};

Result<std::unique_ptr<Camera>> open_aravis(const CameraConfig& config) {
  AravisConfig aravis;
  aravis.id = config.id;
  aravis.trigger = config.trigger;
  aravis.packet_size_bytes = config.packet_size_bytes;
  aravis.receive_priority = kReceivePriority;
  return open_aravis_camera(aravis);
}

Result<std::unique_ptr<Camera>> open_replay(const CameraConfig& config) {
  return open_replay_camera(config.id);
}

Result<std::unique_ptr<Display>> open_sdl(const SlmConfig& config) {
  return open_sdl_display(sdl_config(config));
}

Result<std::unique_ptr<Display>> open_none(const SlmConfig& config) {
  return std::make_unique<NoDisplay>(config.geometry.width_px, config.geometry.height_px);
}

constexpr std::array kCameras{Row<CameraConfig, Camera>{"aravis", open_aravis},
                              Row<CameraConfig, Camera>{kReplayDriver, open_replay}};
constexpr std::array kDisplays{Row<SlmConfig, Display>{"sdl", open_sdl},
                               Row<SlmConfig, Display>{"none", open_none}};

/// The row of a driver. Errc::invalid with this field: there is none.
template <class Table>
Result<typename Table::value_type> row_of(const Table& table, const char* field,
                                          const std::string& name) {
  std::string names;
  for (const auto& row : table) {
    if (name == row.name) return row;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  return fail(Errc::invalid, field, "there is no driver \"" + name + "\": choose one of " + names);
}

auto row_of(const CameraConfig& config) {
  return row_of(kCameras, "camera.driver", config.driver);
}
auto row_of(const SlmConfig& config) {
  return row_of(kDisplays, "slm.driver", config.driver);
}

}  // namespace

Result<std::unique_ptr<Camera>> open_camera(const CameraConfig& config) {
  const auto row = row_of(config);
  return row ? row->open(config) : fail(row.error());
}

Result<std::unique_ptr<Display>> open_display(const SlmConfig& config) {
  const auto row = row_of(config);
  return row ? row->open(config) : fail(row.error());
}

Result<void> check_drivers(const Config& config) {
  if (const auto camera = row_of(config.camera); !camera) return fail(camera.error());
  const auto display = row_of(config.slm);
  return display ? Result<void>{} : fail(display.error());
}

}  // namespace ovws
