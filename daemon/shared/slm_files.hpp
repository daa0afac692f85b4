/// Reads the SLM's LUT and flatness map from files of a lab.
#pragma once

#include <memory>
#include <string>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/hologram.hpp"

namespace ovws {

/// 256 grey levels, 0 to 255, separated by white space or commas; `#` begins a comment. Errors name
/// field "slm.lut" and the place.
Result<PhaseLut> load_lut(const std::string& path);

/// Phase to add, in waves, of exactly width x height pixels: a 16-bit grey PNG (65536 = 1 wave), or
/// text with one row of numbers (waves) a line. Errors name field "slm.flatness".
Result<std::shared_ptr<const Image<float>>> load_flatness(const std::string& path, int width,
                                                          int height);

/// What the hologram is made of, with the files that the configuration names.
Result<HologramConfig> load_hologram_config(const Config& config);

}  // namespace ovws
