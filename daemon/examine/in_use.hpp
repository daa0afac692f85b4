/// What follows from the configuration in use, as config.get reports it.
#pragma once

#include <nlohmann/json.hpp>

#include "config/config.hpp"
#include "proto/json_text.hpp"

namespace ovws::examine {

/// Camera pixels per grating frequency of 1 cycle per SLM pixel.
inline double configured_px_per_cycle(const nlohmann::json& in_use) {
  const nlohmann::json& optics = in_use.at("optics");
  return optics.at("wavelength_nm").get<double>() * optics.at("focal_length_mm").get<double>() *
         optics.at("magnification").get<double>() /
         (in_use.at("slm").at("pitch_um").get<double>() *
          optics.at("camera_pitch_um").get<double>());
}

/// The configuration for predictions of where the spots are: without masks, which move no spot, and
/// whose files are the daemon's.
inline Result<Config> layout_in_use(const nlohmann::json& in_use) {
  auto config = parse_config(json_text(in_use));
  if (config) config->sensor.masks.clear();
  return config;
}

}  // namespace ovws::examine
