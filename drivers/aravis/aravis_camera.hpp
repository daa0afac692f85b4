/// Camera driver for GenICam cameras (GigE Vision or USB3 Vision), based on Aravis.
#pragma once

#include <memory>
#include <string>

#include "core/port/camera.hpp"

namespace ovws {

struct AravisConfig {
  std::string id;                ///< IP address, or Aravis device id, or serial number
  int packet_size_bytes = 9000;  ///< GigE: capped at the device's maximum; 0: keep the device's
  int buffers = 32;              ///< a recorder may hold half of them
  /// GigE without CAP_NET_RAW: size of the socket's receive buffer (SO_RCVBUF).
  int socket_buffer_bytes = 4 << 20;
  /// GigE: SCHED_FIFO priority of Aravis's own thread, which receives packets; 0: the system's
  /// normal scheduling, as without the privilege. For USB3 this thread may turn without a pause
  /// while no buffer is free, and keeps the normal one.
  int receive_priority = 0;
};

/// Opens the camera, takes control, stops an acquisition that a crashed client may have left
/// running, and configures free-running acquisition with all automatic functions off. Errors:
/// Errc::invalid (empty id, or a configured number out of range), Errc::unavailable (no such
/// camera, or controlled by another program), Errc::device.
///
/// In addition to the port's guarantees:
/// - Values are rounded to the camera's nearest step, regions to the next smaller one. An exposure
///   longer than the frame period is refused. `apply` is all or nothing.
/// - A camera that offers only GainRaw has its gain in gain_raw, in device-specific steps.
/// - Frame numbers continue to rise over `stop` and `start`.
/// - `alive` becomes false about 6 s after a GigE camera fell silent, or with the first call that
///   times out. Such a call takes 2.5 to 5 s; every later one fails at once. `stop` takes at most
///   10 s and the destructor 10 s more; together 12.5 s were measured.
/// - Duplicate and late GigE frames are detected from Aravis's packet counters (StrayFrames); USB3
///   cameras send none.
/// - Opening takes about 10 ms by address, 1 s by id, 2.5 s if nothing answers, and 5 s if another
///   program has control.
Result<std::unique_ptr<Camera>> open_aravis_camera(const AravisConfig& config);

}  // namespace ovws
