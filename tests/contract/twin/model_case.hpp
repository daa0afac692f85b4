/// What tests of the twin's models have in common.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

constexpr std::int64_t kNow = 1'800'000'000'123'456'789;
constexpr Roi kWindow{.x = 0, .y = 0, .width = 512, .height = 512};  ///< of the camera

/// Throws what is wrong with it.
inline Config config_of(const std::string& json = "{}") {
  auto config = parse_config(json);
  if (!config) throw std::runtime_error(text_of(config.error()));
  return *config;
}

}  // namespace ovws::twin
