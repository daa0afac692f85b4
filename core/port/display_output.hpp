/// Outputs of the display system that could drive the SLM.
#pragma once

#include <string>

namespace ovws {

/// An output of the display system, open or not.
struct DisplayOutput {
  std::string name;
  std::string monitor;  ///< name of the monitor or SLM; empty: unknown
  bool connected = false, on = false, primary = false;
  int width = 0, height = 0;  ///< video mode, pixels; 0 x 0: off
  double refresh_hz = 0.0;
  std::string reason;     ///< why it cannot be the SLM, and what to do; empty: it can
  bool selected = false;  ///< it is the configured output
};

}  // namespace ovws
