/// Asks a GigE Vision camera what anybody may ask, whoever controls it. Aravis takes the control of
/// every device that it opens, so this speaks the protocol itself.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct GigeAnswer {
  std::string vendor, model, serial;
  bool controlled = false;               ///< some program has its control now
  std::optional<int> link_mbps;          ///< of the camera's own port, if it tells
  std::optional<int> packet_size_bytes;  ///< that it sends now, if it tells
};

/// Errc::unavailable, field "camera.id", after about 1 s if nothing answers at this IPv4 address;
/// Errc::invalid if it is none. Changes nothing in the camera.
Result<GigeAnswer> ask_gige_camera(const std::string& address);

}  // namespace ovws
