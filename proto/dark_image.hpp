/// A camera image without enough light: when it counts as dark, and what to do.
#pragma once

#include <string>

#include "proto/limits.hpp"

namespace ovws {

/// `brightest`: what the brightest pixels reach, as a fraction of full scale.
inline bool is_dark(double brightest) {
  return brightest < limits::kDarkFraction;
}

/// What to do about a dark image; `exposure`: how to set the exposure, in the reader's words.
inline std::string dark_advice(const std::string& exposure) {
  return exposure + ", and check the laser, its shutter and the camera's cover";
}

}  // namespace ovws
