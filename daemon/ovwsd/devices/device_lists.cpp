#include "daemon/ovwsd/devices/device_lists.hpp"

#include <arpa/inet.h>

#include "daemon/ovwsd/devices/sdl_config.hpp"
#include "drivers/aravis/gige_probe.hpp"
#include "drivers/aravis/listing.hpp"

namespace ovws {
namespace {

constexpr const char* kDiscovers = "aravis";  // the camera driver that has a discovery

bool is_address(const std::string& text) {
  in_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1;
}

}  // namespace

std::vector<CameraListing> list_cameras(const CameraConfig& config) {
  if (config.driver != kDiscovers) return {};
  const std::vector<ListedCamera> found = list_cameras();
  const ListedCamera* const selected = find_listed(found, config.id);
  std::vector<CameraListing> all;
  for (const ListedCamera& camera : found) {
    all.push_back({camera.id, camera.serial, camera.address, camera.gige, &camera == selected});
  }
  return all;
}

Result<void> check_camera(const CameraConfig& config, const std::vector<CameraListing>& listed) {
  if (config.driver != kDiscovers) return {};
  std::vector<ListedCamera> cameras;
  for (const CameraListing& one : listed) {
    cameras.push_back({one.id, one.serial, one.address, one.gige});
  }
  if (find_listed(cameras, config.id) != nullptr) return {};
  if (is_address(config.id)) {  // of another network, which the discovery does not reach
    const auto answer = ask_gige_camera(config.id);
    if (!answer) return fail(answer.error());
    return {};
  }
  const std::string names = names_of(cameras);
  return fail(Errc::unavailable, "camera.id",
              "no camera has the id, serial number or address \"" + config.id + "\"; " +
                  (names.empty() ? "no camera answers" : "there are: " + names));
}

Result<std::vector<DisplayOutput>> list_outputs(const SlmConfig& config) {
  return list_sdl_outputs(sdl_config(config));
}

Result<void> check_output(const SlmConfig& config) {
  return check_sdl_output(sdl_config(config));
}

}  // namespace ovws
