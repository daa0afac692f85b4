/// Camera enumeration with Aravis. Does not take control of any camera.
#pragma once

#include <string>
#include <vector>

namespace ovws {

struct ListedCamera {
  std::string id;       ///< Aravis's device id: vendor, model and serial number
  std::string serial;   ///< serial number; empty if the camera has none
  std::string address;  ///< IP address, or name of the USB device; empty if unknown
  bool gige = false;
};

/// Discovers cameras on all networks and USB buses; takes about 1 s. Thread-safe.
std::vector<ListedCamera> list_cameras();

/// Finds the camera with this Aravis device id, serial number or address; null if there is none.
const ListedCamera* find_listed(const std::vector<ListedCamera>& cameras, const std::string& id);

/// List of cameras for messages: "ID at ADDRESS, …"; empty if there are no cameras.
std::string names_of(const std::vector<ListedCamera>& cameras);

}  // namespace ovws
