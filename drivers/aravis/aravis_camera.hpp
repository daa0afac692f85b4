/// Camera driver for GenICam cameras (GigE Vision or USB3 Vision), based on Aravis.
#pragma once

#include <memory>
#include <string>

#include "core/port/camera.hpp"

namespace ovws {

struct AravisConfig {
  std::string id;                ///< IP address, Aravis device id or serial number of the camera
  std::string trigger{};         ///< TriggerSource that starts each frame; empty: free running
  int packet_size_bytes = 9000;  ///< GigE: at most the camera's maximum; 0: keep the camera's value
  int buffers = 32;              ///< frame buffers; a recorder may hold half of the buffers
  /// GigE: size of the socket's receive buffer (SO_RCVBUF). If it cannot hold 8 frames, they arrive
  /// through a packet socket (CAP_NET_RAW), 0 to 5 ms late.
  int socket_buffer_bytes = 4 << 20;
  /// GigE: SCHED_FIFO priority of Aravis's packet-receiving thread. 0, or a missing privilege: the
  /// system's normal scheduling. USB3 always uses normal scheduling, because Aravis's thread may
  /// run a busy loop while no buffer is free.
  int receive_priority = 0;
};

/// Opens the camera, takes control, stops an acquisition that a crashed client may have left
/// running, and configures continuous acquisition, free running or triggered, with all automatic
/// functions off. Errors: Errc::invalid (empty id, or a configured number out of range),
/// Errc::unavailable (no such camera, or controlled by another program), Errc::device.
///
/// In addition to the guarantees of the camera port:
/// - Values are rounded to the camera's nearest step, regions down to the next step. An exposure
///   longer than the frame period is refused. `apply` sets all values or none.
/// - A camera that offers only GainRaw has its gain in gain_raw, in device-specific steps.
/// - Frame numbers continue to rise over `stop` and `start`.
/// - `alive` becomes false about 6 s after a GigE camera stopped answering, or with the first call
///   that times out. A call that times out takes 2.5 to 5 s; later calls fail at once. `stop` takes
///   at most 10 s and the destructor 10 s more; the measured sum was 12.5 s.
/// - Duplicate and late GigE frames are detected from Aravis's packet counters (StrayFrames). USB3
///   cameras send neither.
/// - Opening takes about 10 ms by address, 1 s by id, 2.5 s if nothing answers, and 5 s if another
///   program has control.
Result<std::unique_ptr<Camera>> open_aravis_camera(const AravisConfig& config);

}  // namespace ovws
