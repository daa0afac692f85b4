/// A GenICam camera (GigE Vision or USB3 Vision) through Aravis.
#pragma once

#include <memory>
#include <string>

#include "core/port/camera.hpp"

namespace ovws {

struct AravisConfig {
  std::string id;                ///< IP address, or Aravis device id, or serial number
  int packet_size_bytes = 9000;  ///< GigE: capped by what the device accepts; 0: leave as it is
  int buffers = 16;
  /// GigE without CAP_NET_RAW: receive buffer to ask the kernel for.
  int socket_buffer_bytes = 4 << 20;
};

/// Opens the camera, takes control, and stops an acquisition that a crashed client may have left
/// running. Errors: Errc::unavailable (nothing there, or controlled by another), Errc::device.
Result<std::unique_ptr<Camera>> open_aravis_camera(const AravisConfig& config);

}  // namespace ovws
