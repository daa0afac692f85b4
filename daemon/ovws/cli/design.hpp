/// ovws design: designs a bench offline.
#pragma once

#include <string>

#include "daemon/ovws/design/design.hpp"
#include "daemon/shared/client.hpp"

namespace CLI {
class App;
}

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

/// Designs the bench, prints its figures and what limits it, and writes the requested files. A
/// bench that cannot work is an error with the changes that help.
int design_bench(const Common& common, const DesignOptions& options);

/// ovws advise: compares sensors for the light and the modes that are wanted.
void add_advise(CLI::App& app, const Common& common, int& status);
void add_design(CLI::App& app, const Common& common, int& status);

}  // namespace ovws::cli
