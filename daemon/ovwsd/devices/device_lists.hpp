/// Lists of the devices that could be used, by the drivers of the driver table.
#pragma once

#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "core/port/display.hpp"
#include "proto/tables/devices.hpp"

namespace ovws {

/// Discovers cameras; takes about 1 s. Empty for drivers that have no discovery. Thread-safe.
std::vector<CameraListing> list_cameras(const CameraConfig& config);
/// Checks that the configured camera is in the list or answers at its IP address, which takes about
/// 1 s if it does not. Errc::unavailable, field "camera.id": it is not there; the reason lists the
/// cameras. Drivers without discovery accept every camera.
Result<void> check_camera(const CameraConfig& config, const std::vector<CameraListing>& listed);

/// Lists the outputs of the display system. Main thread only. Errors: the display system does not
/// answer, or does not tell its outputs.
Result<std::vector<DisplayOutput>> list_outputs(const SlmConfig& config);
/// Checks whether the configured output could be opened, without opening it. Main thread only.
Result<void> check_output(const SlmConfig& config);

}  // namespace ovws
