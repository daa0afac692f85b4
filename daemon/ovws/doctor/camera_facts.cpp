#include <algorithm>

#include "daemon/ovws/doctor/camera.hpp"
#include "daemon/ovws/doctor/system_files.hpp"

namespace ovws::doctor {
namespace {

/// Fills in the camera that camera.id means. First it is queried as an address; without an answer
/// it is looked up in the camera list, by address or name, and a GigE camera found there is
/// queried.
void find_camera(CameraFacts& facts) {
  const std::string& id = facts.config.id;
  const auto answer = ask_gige_camera(id);
  if (answer) {
    facts.answer = *answer;
    facts.camera = ListedCamera{answer->vendor + " " + answer->model, answer->serial, id, true};
    return;
  }
  facts.listed = list_cameras();
  const bool by_address = answer.error().code != Errc::invalid;
  if (by_address) {
    const auto heard = std::ranges::find(facts.listed, id, &ListedCamera::address);
    if (heard != facts.listed.end()) facts.camera = *heard;
    return;
  }
  if (const ListedCamera* const named = find_listed(facts.listed, id)) {
    facts.camera = *named;
    if (!named->gige) return;
    if (const auto asked = ask_gige_camera(named->address)) facts.answer = *asked;
  }
}

}  // namespace

CameraFacts read_camera(const CameraConfig& config, DaemonsCamera daemon) {
  CameraFacts facts;
  facts.config = config;
  facts.daemon = daemon;
  find_camera(facts);
  if (facts.camera && !facts.camera->gige) {
    facts.usb_mbps = usb_link_mbps(facts.camera->serial);
  } else if (const auto path = path_to(facts.camera ? facts.camera->address : config.id)) {
    facts.path = *path;
  }
  facts.usbfs_mb = number_of("/sys/module/usbcore/parameters/usbfs_memory_mb");
  facts.rmem_max_bytes = number_of("/proc/sys/net/core/rmem_max");
  return facts;
}

}  // namespace ovws::doctor
