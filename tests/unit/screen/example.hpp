/// Messages that the schemas give as examples.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/shared/schemas/schemas.hpp"

namespace ovws::screen {

inline nlohmann::json example(const std::string& topic) {
  return schema("stream." + topic).at("examples").at(0);
}

}  // namespace ovws::screen
