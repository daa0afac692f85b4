/// Camera checks of `ovws doctor`: presence, control, and the capacity of the link to it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "config/config.hpp"
#include "daemon/examine/machine/finding.hpp"
#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/aravis/camera_link.hpp"
#include "drivers/aravis/gige_probe.hpp"
#include "drivers/aravis/listing.hpp"

namespace ovws::doctor {

/// Whether a daemon answered (`silent`: none did), and whether it has the camera open (`with`) or
/// not (`without`).
enum class DaemonsCamera { silent, without, with };

struct CameraFacts {
  CameraConfig config;
  DaemonsCamera daemon = DaemonsCamera::silent;
  std::vector<ListedCamera>
      listed;  ///< found by discovery; empty if camera.id is an address that answered
  std::optional<ListedCamera> camera;  ///< the camera that camera.id names; none: not found
  std::optional<GigeAnswer> answer;    ///< GigE only: what the camera reports
  std::optional<NetworkPath> path;     ///< GigE only: the route to the camera
  std::optional<int> usb_mbps;         ///< USB only: the speed of the camera's port
  std::optional<std::int64_t> usbfs_mb;
  std::optional<std::int64_t> rmem_max_bytes;
  int buffers = AravisConfig{}.buffers;
  std::int64_t socket_buffer_bytes = AravisConfig{}.socket_buffer_bytes;
};

/// Finds the camera and reads the host's limits. Takes about 1 s; never takes control of a camera.
CameraFacts read_camera(const CameraConfig& config, DaemonsCamera daemon);
Findings judge(const CameraFacts& facts);

}  // namespace ovws::doctor
