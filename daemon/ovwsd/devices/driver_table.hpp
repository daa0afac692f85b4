/// The driver table: from a driver's name to the function that opens its device. A new driver is a
/// folder and one row here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "config/config.hpp"
#include "core/port/camera.hpp"
#include "core/port/display.hpp"

namespace ovws {

/// Camera thread. Errc::invalid (field "camera.driver") for a name that is not in the table.
Result<std::unique_ptr<Camera>> open_camera(const CameraConfig& config);
/// Main thread. Errc::invalid (field "slm.driver") for a name that is not in the table.
Result<std::unique_ptr<Display>> open_display(const SlmConfig& config);

std::vector<std::string> camera_driver_names();
std::vector<std::string> display_driver_names();

}  // namespace ovws
