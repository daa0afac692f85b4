/// Values of JSON messages that may be missing.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace ovws {

/// Part of a message at this JSON pointer; null: there is none.
inline const nlohmann::json& part_at(const nlohmann::json& message, const std::string& path) {
  static const nlohmann::json kNone;
  const nlohmann::json::json_pointer pointer(path);
  return message.contains(pointer) ? message.at(pointer) : kNone;
}

/// Number at this JSON pointer, a bool as 0 or 1; none for any other value.
inline std::optional<double> number_at(const nlohmann::json& message, const std::string& path) {
  const nlohmann::json& value = part_at(message, path);
  if (value.is_boolean()) return value.get<bool>() ? 1.0 : 0.0;
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

/// String at this JSON pointer; empty: there is none.
inline std::string text_at(const nlohmann::json& message, const std::string& path) {
  const nlohmann::json& value = part_at(message, path);
  return value.is_string() ? value.get<std::string>() : std::string();
}

/// A text as JSON; null if it is empty.
inline nlohmann::json text_or_null(const std::string& text) {
  return text.empty() ? nlohmann::json() : nlohmann::json(text);
}

}  // namespace ovws
