/// Enumeration of the cameras that Aravis finds. Does not take control of any camera.
#pragma once

#include <string>
#include <vector>

namespace ovws {

struct ListedCamera {
  std::string id;       ///< Aravis's device id: vendor, model and serial number
  std::string serial;   ///< empty if it has none
  std::string address;  ///< IP address, or name of the USB device; empty if it has none
  bool gige = false;
};

/// Discovers cameras on all networks and USB buses; takes about 1 s.
std::vector<ListedCamera> list_cameras();

/// The camera with this id or serial number; null: none.
const ListedCamera* find_listed(const std::vector<ListedCamera>& cameras, const std::string& id);

/// "ID at ADDRESS, …"; empty if there are none.
std::string names_of(const std::vector<ListedCamera>& cameras);

}  // namespace ovws
