#include "proto/json_text.hpp"

#include <nlohmann/json.hpp>

namespace ovws {

using nlohmann::json;

std::string json_text(const json& value, int indent) {
  return value.dump(indent, ' ', false, json::error_handler_t::replace);
}

json json_of(std::string_view text) {
  return json::parse(text.begin(), text.end(), nullptr, false);
}

}  // namespace ovws
