/// What follows from the configuration in use, as config.get reports it.
#pragma once

#include <array>
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

/// Uses the measured registration of a result of registration.get, if it has one.
inline void use_registration(Config& config, const nlohmann::json& known) {
  const nlohmann::json& map = known.at("px_per_cycle");
  if (!map.is_array()) return;
  const auto [xx, xy, yx, yy] = map.get<std::array<double, 4>>();
  config.optics.registered = PxPerCycle{xx, xy, yx, yy};
}

}  // namespace ovws::examine
