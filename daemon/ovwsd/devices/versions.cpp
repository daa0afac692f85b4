#include "daemon/ovwsd/devices/versions.hpp"

#include <Eigen/Core>

#include <fmt/core.h>

#include "drivers/aravis/aravis_camera.hpp"
#include "drivers/sdl/sdl_display.hpp"
#include "drivers/zmq/publisher.hpp"

namespace ovws {

std::vector<std::pair<std::string, std::string>> versions() {
  return {{"ovws", OVWS_VERSION},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
}

}  // namespace ovws
