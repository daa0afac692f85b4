/// Image of the hologram for the browser. ovws-web renders it with the daemon's own code from the
/// daemon's active settings, so that no pixels are transferred from the daemon.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.hpp"

namespace ovws::web {

struct HologramImage {
  std::uint64_t hologram_id = 0;
  std::uint32_t crc32 = 0;  ///< of the grey levels, row by row, as in slm.verify
  std::string png;
};
using HologramImagePtr = std::shared_ptr<const HologramImage>;

/// Replies of the daemon from which a hologram is rendered.
struct HologramSources {
  nlohmann::json config;      ///< config.get
  nlohmann::json sensor;      ///< sensor.get
  nlohmann::json aberration;  ///< aberration.get
  nlohmann::json correction;  ///< correction.get
  nlohmann::json lut;         ///< lut.get
  nlohmann::json flatness;    ///< flatness.get
  std::string pattern;        ///< system.status: slm.pattern
  friend bool operator==(const HologramSources&, const HologramSources&) = default;
};

/// Renders the hologram and encodes it as PNG; takes tens of milliseconds. Errors:
/// Errc::unavailable if the hologram changed between the replies, if a job shows its own patterns,
/// or if a flatness or mask file is not on this machine.
Result<HologramImagePtr> draw_hologram(const HologramSources& sources);

}  // namespace ovws::web
