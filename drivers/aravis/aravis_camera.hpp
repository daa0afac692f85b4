/// A GenICam camera (GigE Vision or USB3 Vision) through Aravis.
#pragma once

#include <memory>
#include <string>

#include "core/port/camera.hpp"

namespace ovws {

struct AravisConfig {
  std::string id;                ///< IP address, or Aravis device id, or serial number
  int packet_size_bytes = 9000;  ///< GigE: capped by what the device accepts; 0: leave as it is
  int buffers = 32;              ///< half of them may wait for a recorder
  /// GigE without CAP_NET_RAW: receive buffer to ask the kernel for.
  int socket_buffer_bytes = 4 << 20;
};

/// Opens the camera, takes control, stops an acquisition that a crashed client may have left
/// running, and makes it free-running with every automatic function off. Errors: Errc::invalid (id
/// empty, or a number here out of range), Errc::unavailable (nothing there, or controlled by
/// another), Errc::device.
///
/// What this driver adds to the port's promises:
/// - Values between two of the camera's steps go to the nearest, regions back to the next smaller.
///   An exposure longer than the frame period is refused. `apply` is all or nothing.
/// - A camera that knows its gain only as GainRaw has it in steps of its own: gain_db holds those.
/// - Frame numbers go on rising over `stop` and `start`.
/// - `alive` turns false by itself about 6 s after a GigE camera fell silent, or with the first
///   call that gets no answer. Such a call takes 2.5 to 5 s, every later one fails at once; `stop`
///   takes at most 10 s and the destructor 10 s more, together 12.5 s as measured.
/// - GigE frames that come again or after a later one are told from Aravis's packet counts
///   (StrayFrames); USB3 cameras send none.
/// - Opening takes about 10 ms by address and 1 s by id; 2.5 s if nothing answers there; 5 s if
///   another program has control.
Result<std::unique_ptr<Camera>> open_aravis_camera(const AravisConfig& config);

}  // namespace ovws
