/// A small bench, quick to render.
#pragma once

#include "config/config.hpp"
#include "core/optics/hologram.hpp"
#include "core/port/camera.hpp"
#include "daemon/ovwsd/library/slm_measured.hpp"
#include "proto/tables/optics.hpp"

namespace ovws::test {

inline const CameraInfo kCamera{"Ovws", "Twin", "TWIN0001", "127.0.0.1"};

inline Config small_bench() {
  Config config;
  config.slm.geometry = {160, 96, 19.0};
  config.sensor.pupil_diameter_px = 96.0;
  config.sensor.subapertures_across = 3;
  config.sensor.grooves = {20.0, 4.0};
  config.camera.settings.roi = {16, 8, 32, 24};
  return config;
}

inline HologramConfig hologram_of(const Config& config) {
  HologramConfig hologram;
  hologram.slm = config.slm.geometry;
  hologram.sensor = config.sensor;
  return hologram;
}

/// The bench of this configuration with kCamera.
inline BenchKey key_of(const Config& config,
                       const std::optional<Registration>& registration = std::nullopt) {
  BenchKey key{config.sensor,
               config.tracking,
               config.camera.settings.roi,
               to_json(config.optics),
               slm_identity(hologram_of(config), false),
               camera_json(kCamera),
               nullptr,
               nullptr,
               {},
               {}};
  use_map(key, registration, config.optics, config.slm.geometry);
  return key;
}

}  // namespace ovws::test
