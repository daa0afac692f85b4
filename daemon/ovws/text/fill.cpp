#include "daemon/ovws/text/fill.hpp"

#include <fmt/chrono.h>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <map>
#include <utility>
#include <vector>

#include "core/base/number_text.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/ovws/text/answer.hpp"
#include "daemon/ovws/text/quantity.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

std::string items_text(const json& list) {
  std::vector<std::string> all;
  for (const json& one : list) all.push_back(one.is_string() ? one.get<std::string>() : one.dump());
  return fmt::format("{}", fmt::join(all, ", "));
}

std::string clock_text(const json& t_ns) {
  const std::time_t second = t_ns.get<std::int64_t>() / 1'000'000'000;
  return fmt::format("{:%H:%M:%S}", fmt::localtime(second));
}

using Format = std::string (*)(const json&);
const std::map<std::string_view, Format> kFormats{
    {"age", [](const json& t_ns) { return age_text(t_ns.get<std::int64_t>()); }},
    {"camera", camera_settings_text},
    {"clock", clock_text},
    {"count", [](const json& list) { return std::to_string(list.size()); }},
    {"exposure", [](const json& settings) { return exposure_text(settings, {}); }},
    {"gain", [](const json& settings) { return gain_text(settings, {}); }},
    {"json", [](const json& value) { return value.dump(); }},
    {"list", items_text},
    {"mode", [](const json& j) { return zernike_name(j.get<int>()); }},
    {"modes", modes_text},
    {"signed", [](const json& value) { return signed_decimals(value.get<double>(), 4); }},
    {"size", [](const json& bytes) { return size_text(bytes.get<double>()); }},
    {"time", [](const json& seconds) { return time_text(seconds.get<double>()); }}};

/// Takes the text before the next one of these characters, and that character.
std::string_view take_until(std::string_view& form, std::string_view ends) {
  const std::size_t at = std::min(form.find_first_of(ends), form.size());
  const std::string_view taken = form.substr(0, at);
  form.remove_prefix(std::min(at + 1, form.size()));
  return taken;
}

/// The value at a path; null if there is none.
const json* find(std::string_view path, const json& values) {
  const json* at = &values;
  while (!path.empty() && path != "." && at != nullptr) {
    const std::string key(take_until(path, "."));
    const json* const outer = std::exchange(at, nullptr);
    if (outer->is_object() && outer->contains(key)) at = &outer->at(key);
    std::size_t index = outer->size();
    const auto read = std::from_chars(key.data(), key.data() + key.size(), index);
    if (outer->is_array() && read.ec == std::errc() && index < outer->size()) {
      at = &outer->at(index);
    }
  }
  return at;
}

bool ends_with_any(const std::string& format, std::string_view kinds) {
  return !format.empty() && kinds.find(format.back()) != std::string_view::npos;
}

/// A number by a format of fmt: decimals of a whole number, too.
std::string number_text(const json& number, const std::string& format) {
  const std::string form = "{:" + format + "}";
  const bool is_decimal = number.is_number_float() || ends_with_any(format, "efg");
  if (is_decimal && !format.ends_with('d')) {
    return fmt::format(fmt::runtime(form), number.get<double>());
  }
  return fmt::format(fmt::runtime(form), number.get<std::int64_t>());
}

/// `expression`: KEY, KEY*FACTOR or KEY/FACTOR, then :FORMAT.
std::string value_text(std::string_view expression, const json& values) {
  std::string_view path = take_until(expression, ":");
  const std::string format(expression);
  const std::size_t sign = path.find_first_of("*/");
  const json* const found = find(path.substr(0, sign), values);
  if (found == nullptr) return values.at(std::string(path));  // throws, with the key
  if (const auto named = kFormats.find(format); named != kFormats.end()) {
    return named->second(*found);
  }
  if (found->is_null()) return "?";
  if (sign == path.npos && (found->is_number() || ends_with_any(format, "defg"))) {
    return number_text(*found, format);
  }
  if (sign == path.npos) {
    return fmt::format(fmt::runtime("{:" + format + "}"), found->get<std::string>());
  }
  const double factor = finite_number(std::string(path.substr(sign + 1))).value();
  const double value = found->get<double>();
  return number_text(path[sign] == '*' ? value * factor : value / factor, format);
}

bool is_something(const json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number()) return value.get<double>() != 0.0;
  return value.is_string() ? !value.get_ref<const std::string&>().empty() : !value.empty();
}

bool holds(std::string_view condition, const json& values) {
  if (condition.starts_with('!')) return !holds(condition.substr(1), values);
  if (const auto either = condition.find('|'); either != condition.npos) {
    return holds(condition.substr(0, either), values) ||
           holds(condition.substr(either + 1), values);
  }
  if (condition.find(':') != condition.npos) return !value_text(condition, values).empty();
  const std::size_t equals = condition.find('=');
  const json* const found = find(condition.substr(0, equals), values);
  if (found == nullptr || equals == condition.npos) return found != nullptr && is_something(*found);
  return items_text(json::array({*found})) == condition.substr(equals + 1);
}

/// Takes the template up to a closing bracket of an outer condition. `values` null: says nothing.
std::string fill_part(std::string_view& form, const json* values) {
  std::string text;
  while (!form.empty() && form.front() != ']') {
    const char first = form.front();
    form.remove_prefix(1);
    if (first == '{') {
      const std::string_view expression = take_until(form, "}");
      if (values != nullptr) text += value_text(expression, *values);
    } else if (first == '[') {
      const std::size_t end = form.find_first_of("?*");
      const bool is_list = form[end] == '*';
      const std::string_view condition = take_until(form, "?*");
      const std::string_view inner = form;
      const bool is_said = values != nullptr && !is_list && holds(condition, *values);
      text += fill_part(form, is_said ? values : nullptr);
      form.remove_prefix(1);
      if (values == nullptr || !is_list) continue;
      const json* const list = find(condition, *values);
      for (const json& item : list != nullptr ? *list : values->at(std::string(condition))) {
        std::string_view again = inner;
        text += fill_part(again, &item);
      }
    } else if (values != nullptr) {
      text += first;
    }
  }
  return text;
}

}  // namespace

std::string fill(std::string_view form, const json& values) {
  std::string text = fill_part(form, &values);
  if (text.ends_with('\n')) text.pop_back();
  return text;
}

}  // namespace ovws::cli
