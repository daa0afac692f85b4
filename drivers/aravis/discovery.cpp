/// Lookup and opening of devices.
#include "drivers/aravis/discovery.hpp"

#include <utility>

#include "drivers/aravis/listing.hpp"

namespace ovws {

namespace {

constexpr const char* kField = "camera.id";

struct Listing {
  std::string address;
  bool gige = false;
};

/// The one device that has this id or serial number.
Result<Listing> look_up(const std::string& id) {
  const auto cameras = list_cameras();
  if (const ListedCamera* const camera = find_listed(cameras, id)) {
    const bool by_address = camera->gige && !camera->address.empty();
    return Listing{by_address ? camera->address : camera->id, camera->gige};
  }
  const std::string found = names_of(cameras);
  return fail(Errc::unavailable, kField,
              "no camera has the id or serial number " + id + "; " +
                  (found.empty() ? "no camera was found at all; check cable, power and network"
                                 : "cameras found: " + found));
}

}  // namespace

Result<FoundDevice> find_device(const std::string& id) {
  if (id.empty())
    return fail(Errc::invalid, kField, "give the camera's IP address, id or serial number");
  Listing listing{id, true};
  if (!g_hostname_is_ip_address(id.c_str())) {
    auto listed = look_up(id);
    if (!listed) return fail(listed.error());
    listing = *listed;
  }
  GErrorSlot error;
  // For an IP address open through the GigE interface only: otherwise Aravis searches all USB
  // devices first.
  GRef<ArvDevice> device(listing.gige
                             ? arv_interface_open_device(arv_gv_interface_get_instance(),
                                                         listing.address.c_str(), error.out())
                             : arv_open_device(listing.address.c_str(), error.out()));
  if (!device)
    return fail(Errc::unavailable, kField,
                "no camera answers at " + listing.address + "; check its cable, power and address");
  if (ARV_IS_GV_DEVICE(device.get()) && !arv_gv_device_is_controller(ARV_GV_DEVICE(device.get())))
    return fail(Errc::unavailable, kField,
                "the camera at " + listing.address +
                    " is controlled by another program; close it, or wait a few seconds if it has "
                    "just ended");
  return FoundDevice{std::move(device), listing.address};
}

}  // namespace ovws
