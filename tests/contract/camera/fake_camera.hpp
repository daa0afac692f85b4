/// The GigE Vision camera in another process that the Aravis driver is tested with.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "tests/contract/camera/child_process.hpp"

namespace ovws::testing {

constexpr const char* kFakeCameraAddress = "127.0.0.1";

/// `xml`: its GenICam description; "-": Aravis's built-in one.
inline std::unique_ptr<ChildProcess> start_fake_camera(const std::string& xml,
                                                       const std::string& lost_packet_ratio = "0") {
  auto device = std::make_unique<ChildProcess>(
      std::vector<std::string>{OVWS_FAKE_GIGE_CAMERA, kFakeCameraAddress, xml, lost_packet_ratio});
  if (device->read_line() != "ready") throw std::runtime_error("the camera is not ready");
  return device;
}

}  // namespace ovws::testing
