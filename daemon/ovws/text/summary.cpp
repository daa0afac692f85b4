/// The summary of any result: one line per key.
#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "daemon/ovws/text/answer.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

constexpr std::size_t kMostItems = 8;  ///< longer lists are summarised by their length

/// Keys that only programs need: times in nanoseconds, hashes, and the bench of a measurement.
bool is_for_programs(const std::string& key) {
  return key.ends_with("_ns") || key.ends_with("sha256") || key == "origin" || key == "schema";
}

std::string number_text(const json& number) {
  return number.is_number_float() ? fmt::format("{:.6g}", number.get<double>()) : json_text(number);
}

std::string value_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number()) return number_text(value);
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (!value.is_array()) return json_text(value);
  const bool plain =
      std::all_of(value.begin(), value.end(), [](const json& one) { return one.is_primitive(); });
  if (!plain || value.size() > kMostItems) return fmt::format("({} entries)", value.size());
  std::string text;
  for (const json& one : value) text += (text.empty() ? "" : ", ") + value_text(one);
  return text;
}

void put_lines(std::vector<std::pair<std::string, std::string>>& lines, const std::string& prefix,
               const json& object) {
  for (const auto& [key, value] : object.items()) {
    if (value.is_null() || is_for_programs(key)) continue;
    if (value.is_structured() && value.empty()) continue;
    if (value == "") continue;
    if (value.is_object()) {
      put_lines(lines, prefix + key + ".", value);
    } else {
      lines.emplace_back(prefix + key, value_text(value));
    }
  }
}

}  // namespace

std::string summary_text(const json& result) {
  if (!result.is_object()) return value_text(result);
  std::vector<std::pair<std::string, std::string>> lines;
  put_lines(lines, "", result);
  std::size_t width = 0;
  for (const auto& [key, value] : lines) width = std::max(width, key.size());
  std::string text;
  for (const auto& [key, value] : lines) {
    text += fmt::format("{}{:<{}}  {}", text.empty() ? "" : "\n", key, width, value);
  }
  return text.empty() ? "nothing" : text;
}

}  // namespace ovws::cli
