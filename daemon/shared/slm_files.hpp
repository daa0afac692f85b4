/// Loads the SLM's LUT, its flatness map and the subapertures' masks from files.
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

/// Reads the maps of `sensor.mask.file` that are not read yet: the phase to add in a subaperture,
/// waves, over the square around it, in a file like a flatness map. Sets maps and checksums. Errors
/// (Errc::invalid, field "sensor.mask…"): a file cannot be read, or is not the one with the
/// expected checksum; what check_masks refuses.
Result<void> load_masks(SensorConfig& sensor);
/// load_config, with the masks that the configuration names. An empty path: the default.
Result<Config> load_config_and_masks(const std::string& path);

/// Builds the hologram's configuration and loads the LUT and flatness files that it names.
Result<HologramConfig> load_hologram_config(const Config& config);

}  // namespace ovws
