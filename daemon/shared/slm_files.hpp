/// Loads the SLM's LUT and flatness map from files.
#pragma once

#include <memory>
#include <string>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/hologram.hpp"

namespace ovws {

/// Loads a look-up table: 256 grey levels from 0 to 255, separated by white space, commas or
/// semicolons; `#` begins a comment. Errors name field "slm.lut" and the wrong entry.
Result<PhaseLut> load_lut(const std::string& path);

/// Loads a flatness map: the phase to add, in waves, with exactly width x height pixels: from a
/// 16-bit greyscale PNG (65536 = 1 wave), or from text with one row of numbers (waves) per line.
/// Errors name field "slm.flatness".
Result<std::shared_ptr<const Image<float>>> load_flatness(const std::string& path, int width,
                                                          int height);

/// Builds the hologram's configuration and loads the LUT and flatness files that it names.
Result<HologramConfig> load_hologram_config(const Config& config);

}  // namespace ovws
