/// The devices of a bench that ovws design and ovws advise are given.
#pragma once

#include <string>

#include "daemon/ovws/design/design.hpp"

namespace ovws::cli {

struct DesignOptions {
  std::string slm, camera;  ///< the name of a model, or "WIDTHxHEIGHT@PITCH"
  design::Bench bench;      ///< without slm and camera
  std::string pixel_format = "Mono8";
  std::string config_path;  ///< configuration whose other keys are kept; empty: the defaults
  std::string output;       ///< configuration to write; empty: none
  std::string farfield;     ///< PNG to write; empty: none
  bool replace = false;
  bool list = false;
};

/// The bench with its SLM, camera and pixel format. Errors (Errc::invalid, field "--slm" or
/// "--camera"): no known model and no valid size, with the nearest name.
Result<design::Bench> bench_of(const DesignOptions& options);

}  // namespace ovws::cli
