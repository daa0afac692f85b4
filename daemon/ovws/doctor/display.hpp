/// Is the SLM's output there, of the right mode, and left alone by the desktop?
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/ovws/doctor/finding.hpp"
#include "drivers/sdl/display_probe.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws::doctor {

struct DisplayFacts {
  SdlConfig config;
  Result<sdl::DisplayProbe> probe;
  bool server_named = false;  ///< DISPLAY is set
};

/// Takes some seconds if the X server does not answer; asked once in a process. Opens no window.
DisplayFacts read_display(const SlmConfig& config);
Findings judge(const DisplayFacts& facts);

}  // namespace ovws::doctor
