/// The daemon's states, as system.status names them.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace ovws {

/// In order of precedence: the current state is the first whose condition holds.
enum class DaemonState : std::uint8_t {
  stopping,             ///< shutdown requested
  starting,             ///< drivers have not been opened yet
  fault,                ///< a device is present but unusable until a person fixes it
  waiting_for_camera,   ///< no camera; possibly no display either
  waiting_for_display,  ///< a camera, but no display
  job_running,          ///< a job has the sensor
  running,
  count,
};

constexpr std::array<std::string_view, std::size_t(DaemonState::count)> kStateNames{
    "stopping",    "starting", "fault", "waiting_for_camera", "waiting_for_display",
    "job_running", "running"};

constexpr std::string_view state_name(DaemonState state) {
  return kStateNames[std::size_t(state)];
}

}  // namespace ovws
