/// Display checks of `ovws doctor`: the SLM's X output, its mode, and interference by the desktop.
#pragma once

#include "config/config.hpp"
#include "core/base/result.hpp"
#include "daemon/examine/machine/finding.hpp"
#include "drivers/sdl/display_probe.hpp"
#include "drivers/sdl/sdl_display.hpp"

namespace ovws::doctor {

struct DisplayFacts {
  SdlConfig config;
  Result<sdl::DisplayProbe> probe;
  bool server_named = false;  ///< the environment variable DISPLAY is set
  bool daemon_shows = false;  ///< a daemon that answers has the SLM's output open
};

/// Probes the X server. Takes up to 3 s if it does not answer; call it once per process. Opens no
/// window. `daemon_shows`: see DisplayFacts.
DisplayFacts read_display(const SlmConfig& config, bool daemon_shows);
Findings judge(const DisplayFacts& facts);

}  // namespace ovws::doctor
