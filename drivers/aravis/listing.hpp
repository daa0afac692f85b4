/// The cameras that Aravis sees from here, as data. Nobody's control of one is touched.
#pragma once

#include <string>
#include <vector>

namespace ovws {

struct ListedCamera {
  std::string id;       ///< Aravis's own: vendor, model and serial number in one
  std::string serial;   ///< empty if it has none
  std::string address;  ///< IP address, or USB's own name of the device; empty if it has none
  bool gige = false;
};

/// Asks all networks and USB buses; takes about 1 s.
std::vector<ListedCamera> list_cameras();

/// The one whose id or serial number this is; null: none.
const ListedCamera* find_listed(const std::vector<ListedCamera>& cameras, const std::string& id);

/// "ID at ADDRESS, …"; empty if there are none.
std::string names_of(const std::vector<ListedCamera>& cameras);

}  // namespace ovws
