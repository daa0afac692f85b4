/// Lookup and opening of devices.
#include "drivers/aravis/discovery.hpp"

#include <utility>

namespace ovws {

namespace {

constexpr const char* kField = "camera.id";

struct Listing {
  std::string address;
  bool gige = false;
};

bool same(const char* given, const std::string& wanted) {
  return given && wanted == given;
}

/// The one device that has this id or serial number.
Result<Listing> look_up(const std::string& id) {
  arv_update_device_list();
  std::string seen;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    const char* address = arv_get_device_address(i);
    const bool gige = same(arv_get_device_protocol(i), "GigEVision");
    if (same(arv_get_device_id(i), id) || same(arv_get_device_serial_nbr(i), id))
      return Listing{gige && address ? address : arv_get_device_id(i), gige};
    seen += (seen.empty() ? "" : ", ") + std::string(arv_get_device_id(i));
    if (address) seen += " at " + std::string(address);
  }
  return fail(Errc::unavailable, kField,
              "there is no camera with the id or serial number " + id + "; " +
                  (seen.empty() ? "none was found at all; check cable, power and network"
                                : "found were: " + seen));
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
  // Only GigE is asked for an IP address: Aravis would otherwise go through all USB devices first.
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
                    " is controlled by another program; close that, or wait a few seconds if it "
                    "has just ended");
  return FoundDevice{std::move(device), listing.address};
}

}  // namespace ovws
