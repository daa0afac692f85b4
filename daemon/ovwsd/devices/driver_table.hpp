/// Driver table: maps a driver's name to the function that opens its device. To add a driver, add
/// its folder and one row in this table.
#pragma once

#include <memory>

#include "config/config.hpp"
#include "core/port/camera.hpp"
#include "core/port/display.hpp"

namespace ovws {

/// Opens the configured camera, in the camera thread. Errc::invalid (field "camera.driver"): the
/// driver's name is not in the table.
Result<std::unique_ptr<Camera>> open_camera(const CameraConfig& config);
/// Opens the configured display, in the main thread. Errc::invalid (field "slm.driver"): the
/// driver's name is not in the table.
Result<std::unique_ptr<Display>> open_display(const SlmConfig& config);

/// Whether the configured drivers are in the table. Errors: as above, with the drivers that are.
Result<void> check_drivers(const Config& config);

}  // namespace ovws
