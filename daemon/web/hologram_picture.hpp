/// The hologram as a picture for a browser, made by the daemon's own code from what the daemon says
/// is in force: no pixel of it crosses the wire from the daemon.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.hpp"

namespace ovws::web {

struct HologramPicture {
  std::uint64_t hologram_id = 0;
  std::uint32_t crc32 = 0;  ///< of the grey levels, row by row, as slm.verify gives it
  std::string png;
};
using HologramPicturePtr = std::shared_ptr<const HologramPicture>;

/// Results of the daemon's methods of these names.
struct HologramSources {
  nlohmann::json config;      ///< config.get
  nlohmann::json sensor;      ///< sensor.get
  nlohmann::json aberration;  ///< aberration.get
  nlohmann::json correction;  ///< correction.get
  nlohmann::json lut;         ///< lut.get
  nlohmann::json flatness;    ///< flatness.get
  std::string pattern;        ///< status: slm.pattern
};

/// Takes tens of milliseconds. Errors: Errc::unavailable if the hologram changed between the
/// answers, if a job paints its own, or if the flatness file is not on this machine.
Result<HologramPicturePtr> draw_hologram(const HologramSources& sources);

}  // namespace ovws::web
