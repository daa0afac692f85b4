/// Models of SLMs and of camera sensors with their sizes and pixel pitches: devices.json.
#pragma once

#include <string>
#include <vector>

#include "core/optics/geometry.hpp"

namespace ovws {

struct SlmModel {
  std::string name;
  SlmGeometry geometry;  ///< of the video mode by which it is driven
  double settle_ms = 0.0;
  bool confirmed = false;  ///< a public document was found that states size and pitch
  std::string source;
};

struct CameraModel {
  std::string name;
  int width = 0;  ///< of the region that the camera sends by default, pixels
  int height = 0;
  double pitch_um = 0.0;
  bool confirmed = false;  ///< as of SlmModel
  std::string source;
};

struct Devices {
  std::vector<SlmModel> slms;
  std::vector<CameraModel> cameras;
};

/// All models of devices.json, which is compiled in. Thread-safe.
const Devices& known_devices();

}  // namespace ovws
