/// GigE Vision camera probe that takes no control, so it works while another program controls the
/// camera. Implements GVCP itself, because Aravis takes control of every device that it opens.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct GigeAnswer {
  std::string vendor, model, serial;
  bool controlled = false;               ///< a program controls the camera now
  std::optional<int> link_mbps;          ///< link speed of the camera's port, if reported
  std::optional<int> packet_size_bytes;  ///< current stream packet size, if reported
};

/// GigE Vision bootstrap register "Control Channel Privilege", and its bits for exclusive access
/// and control access.
inline constexpr std::uint32_t kControlRegister = 0x0a00, kControlBits = 0x3;

/// Discovers the camera and reads its bootstrap registers; changes nothing. Errors, field
/// "camera.id": Errc::unavailable after about 1 s if no camera answers at this address,
/// Errc::invalid if it is not an IPv4 address.
Result<GigeAnswer> ask_gige_camera(const std::string& address);

}  // namespace ovws
