/// Probe of a GigE Vision camera that needs no control and works while another program controls it.
/// Speaks GVCP itself, because Aravis takes control of every device that it opens.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.hpp"

namespace ovws {

struct GigeAnswer {
  std::string vendor, model, serial;
  bool controlled = false;               ///< a program controls the camera now
  std::optional<int> link_mbps;          ///< of the camera's port, if it reports one
  std::optional<int> packet_size_bytes;  ///< current one, if the camera reports it
};

/// Discovers the camera and reads its bootstrap registers; changes nothing. Errors, field
/// "camera.id": Errc::unavailable after about 1 s if nothing answers at this IPv4 address,
/// Errc::invalid if it is not one.
Result<GigeAnswer> ask_gige_camera(const std::string& address);

}  // namespace ovws
