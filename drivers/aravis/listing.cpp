#include "drivers/aravis/listing.hpp"

#include <arv.h>

#include <algorithm>
#include <mutex>

#include "core/base/printable.hpp"

namespace ovws {

namespace {

std::string text_of(const char* given) {
  return given != nullptr ? given : "";
}

}  // namespace

std::vector<ListedCamera> list_cameras() {
  static std::mutex one_at_a_time;  // Aravis replaces its list, whose texts are read below
  const std::lock_guard lock(one_at_a_time);
  arv_update_device_list();
  std::vector<ListedCamera> cameras;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    cameras.push_back({text_of(arv_get_device_id(i)), text_of(arv_get_device_serial_nbr(i)),
                       text_of(arv_get_device_address(i)),
                       text_of(arv_get_device_protocol(i)) == "GigEVision"});
  }
  return cameras;
}

const ListedCamera* find_listed(const std::vector<ListedCamera>& cameras, const std::string& id) {
  const auto found = std::ranges::find_if(cameras, [&](const ListedCamera& camera) {
    return !id.empty() && (camera.id == id || camera.serial == id || camera.address == id);
  });
  return found != cameras.end() ? &*found : nullptr;
}

std::string names_of(const std::vector<ListedCamera>& cameras) {
  std::string names;
  for (const ListedCamera& camera : cameras) {
    names += (names.empty() ? "" : ", ") + printable(camera.id, kMaxNameBytes);
    if (!camera.address.empty()) names += " at " + printable(camera.address, kMaxNameBytes);
  }
  return names;
}

}  // namespace ovws
