/// Is the camera there, in whose hands, and does what lies between let its frames through?
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "config/config.hpp"
#include "daemon/ovws/doctor/finding.hpp"
#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/aravis/camera_link.hpp"
#include "drivers/aravis/gige_probe.hpp"
#include "drivers/aravis/listing.hpp"

namespace ovws::doctor {

/// Whether the daemon that was asked has the camera.
enum class DaemonsCamera { silent, without, with };

struct CameraFacts {
  CameraConfig config;
  DaemonsCamera daemon = DaemonsCamera::silent;
  std::vector<ListedCamera> listed;    ///< asked for only if the address did not answer
  std::optional<ListedCamera> camera;  ///< the configured one
  std::optional<GigeAnswer> answer;    ///< of a GigE camera
  std::optional<NetworkPath> path;     ///< to a GigE camera
  std::optional<int> usb_mbps;         ///< of a USB camera's port
  std::optional<std::int64_t> usbfs_mb;
  std::optional<std::int64_t> rmem_max_bytes;
  int buffers = AravisConfig{}.buffers;
  std::int64_t socket_buffer_bytes = AravisConfig{}.socket_buffer_bytes;
};

/// Takes about a second, and no camera's control.
CameraFacts read_camera(const CameraConfig& config, DaemonsCamera daemon);
Findings judge(const CameraFacts& facts);

}  // namespace ovws::doctor
