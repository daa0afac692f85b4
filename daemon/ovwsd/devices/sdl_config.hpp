/// The SDL driver's configuration.
#pragma once

#include "config/config.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws {

inline SdlConfig sdl_config(const SlmConfig& config) {
  return {config.display, config.geometry.width_px, config.geometry.height_px,
          config.allow_primary};
}

}  // namespace ovws
