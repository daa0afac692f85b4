/// Holograms as images.
#pragma once

#include <cstdint>
#include <vector>

#include "core/optics/hologram.hpp"

namespace ovws::test {

inline Image<std::uint8_t> rendered(const HologramConfig& config, HologramKind kind,
                                    std::vector<Mode> modes = {}) {
  Image<std::uint8_t> grey;
  HologramRenderer::make(config).value().render(kind, modes, grey);
  return grey;
}

}  // namespace ovws::test
