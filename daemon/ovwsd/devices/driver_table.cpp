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

template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  for (const auto& row : table) names.emplace_back(row.name);
  return names;
}

}  // namespace

Result<std::unique_ptr<Camera>> open_camera(const CameraConfig& config) {
  for (const auto& row : kCameras) {
    if (config.driver == row.name) return row.open(config);
  }
  return fail(Errc::invalid, "camera.driver",
              "there is no camera driver \"" + config.driver + "\"");
}

Result<std::unique_ptr<Display>> open_display(const SlmConfig& config) {
  for (const auto& row : kDisplays) {
    if (config.driver == row.name) return row.open(config);
  }
  return fail(Errc::invalid, "slm.driver", "there is no display driver \"" + config.driver + "\"");
}

std::vector<std::string> camera_driver_names() {
  return names_of(kCameras);
}
std::vector<std::string> display_driver_names() {
  return names_of(kDisplays);
}

}  // namespace ovws
