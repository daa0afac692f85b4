/// A camera image that the daemon cannot measure: it has no measurement plan for it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ovws {

/// Why the daemon of this `status` cannot measure the camera's image, and what to do; empty if it
/// can. No frame is valid then, or none is published, and a new reference does not help.
inline std::string why_not_measurable(const nlohmann::json& status) {
  const nlohmann::json& sensor = status.at("sensor");
  if (sensor.value("measurable", true) || !sensor.at("invalid").is_object()) return {};
  const nlohmann::json& invalid = sensor.at("invalid");
  return invalid.at("reason").get<std::string>() + "; " + invalid.at("action").get<std::string>();
}

}  // namespace ovws
