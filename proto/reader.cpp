#include "proto/reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>

#include "proto/json_text.hpp"

namespace ovws {
namespace {

using nlohmann::json;

/// Number text for messages: 100000 instead of 1e+05.
std::string text_of(double value) {
  constexpr double kMaxWhole = 1e15;
  if (value == std::floor(value) && std::abs(value) < kMaxWhole) {
    return std::to_string(std::int64_t(value));
  }
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

/// A value in an error message: the value itself if it is short, else its type.
std::string described(const json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array";
  const std::string text = json_text(value);
  return text.size() <= 40 ? text : std::string("a long ") + value.type_name();
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "\"" : ", \"") + name + "\"";
  return text;
}

std::string suggestion(const std::string& nearest, const std::vector<std::string>& known) {
  if (!nearest.empty()) return "did you mean \"" + nearest + "\"?";
  return known.empty() ? "no key is allowed here" : "known are " + listed(known);
}

}  // namespace

ObjectReader::ObjectReader(const json& object, std::string path)
    : json_(object), path_(std::move(path)) {
  if (!json_.is_object()) {
    error_ = Error{Errc::invalid, path_, "must be an object, not " + described(json_)};
  }
}

std::string ObjectReader::path_of(std::string_view key) const {
  if (key.empty()) return path_;
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

bool ObjectReader::has(const char* key) const {
  return json_.is_object() && json_.contains(key);
}

const json* ObjectReader::take(const char* key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  if (error_) return nullptr;
  const auto found = json_.find(key);
  return found == json_.end() ? nullptr : &*found;
}

bool ObjectReader::is_null(const char* key) {
  const json* value = take(key);
  return value != nullptr && value->is_null();
}

const json* ObjectReader::raw(const char* key) {
  return take(key);
}

void ObjectReader::require(const char* key) {
  if (!missing_ && !has(key)) missing_ = Error{Errc::invalid, path_of(key), "is missing"};
}

void ObjectReader::fault(std::string_view key, std::string reason) {
  if (!error_) error_ = Error{Errc::invalid, path_of(key), std::move(reason)};
}

std::optional<double> ObjectReader::number_in(const std::string& field, const json& value,
                                              double min, double max, bool whole) {
  const auto range = text_of(min) + " to " + text_of(max);
  const auto kind = std::string(whole ? "a whole number" : "a number");
  const double got = value.is_number() ? value.get<double>() : 0.0;
  if (!value.is_number() || !std::isfinite(got) || (whole && got != std::floor(got))) {
    error_ = Error{Errc::invalid, field,
                   "must be " + kind + " from " + range + ", not " + described(value), min, max};
    return std::nullopt;
  }
  if (got >= min && got <= max) return got;
  if (clamp_) return std::clamp(got, min, max);
  error_ = Error{Errc::invalid, field,
                 "must be " + kind + " from " + range + ", not " + text_of(got), min, max};
  return std::nullopt;
}

void ObjectReader::number(const char* key, double& out, double min, double max) {
  const json* value = take(key);
  if (value == nullptr) return;
  if (const auto got = number_in(path_of(key), *value, min, max, false)) out = *got;
}

void ObjectReader::integer(const char* key, int& out, int min, int max) {
  const json* value = take(key);
  if (value == nullptr) return;
  if (const auto got = number_in(path_of(key), *value, min, max, true)) out = int(*got);
}

void ObjectReader::integer(const char* key, std::int64_t& out, double min, double max) {
  const json* value = take(key);
  if (value == nullptr) return;
  const auto got = number_in(path_of(key), *value, min, max, true);
  if (!got) return;
  const bool exact = value->is_number_integer() && *got == value->get<double>();
  out = exact ? value->get<std::int64_t>() : std::int64_t(*got);
}

void ObjectReader::boolean(const char* key, bool& out) {
  const json* value = take(key);
  if (value == nullptr) return;
  if (!value->is_boolean()) return fault(key, "must be true or false, not " + described(*value));
  out = value->get<bool>();
}

void ObjectReader::string(const char* key, std::string& out) {
  const json* value = take(key);
  if (value == nullptr) return;
  if (!value->is_string()) return fault(key, "must be a string, not " + described(*value));
  out = value->get<std::string>();
}

void ObjectReader::choice(const char* key, int& out, const std::vector<std::string>& names) {
  const json* value = take(key);
  if (value == nullptr) return;
  if (!value->is_string()) {
    return fault(key, "must be one of " + listed(names) + ", not " + described(*value));
  }
  const auto found = std::find(names.begin(), names.end(), value->get_ref<const std::string&>());
  if (found != names.end()) {
    out = int(found - names.begin());
    return;
  }
  const auto nearest = nearest_name(value->get_ref<const std::string&>(), names).value_or("");
  fault(key, described(*value) + " is unknown; known are " + listed(names) +
                 (nearest.empty() ? "" : "; did you mean \"" + nearest + "\"?"));
  error_->nearest = nearest;
}

void ObjectReader::numbers(const char* key, std::vector<double>& out, std::size_t min_size,
                           std::size_t max_size, double min, double max) {
  const json* value = take(key);
  if (value == nullptr) return;
  if (!value->is_array() || value->size() < min_size || value->size() > max_size) {
    const auto count = min_size == max_size
                           ? std::to_string(min_size)
                           : std::to_string(min_size) + " to " + std::to_string(max_size);
    return fault(key, "must be an array of " + count + " numbers");
  }
  std::vector<double> read;
  for (std::size_t i = 0; i < value->size(); ++i) {
    const auto field = path_of(key) + "[" + std::to_string(i) + "]";
    const auto got = number_in(field, (*value)[i], min, max, false);
    if (!got) return;
    read.push_back(*got);
  }
  out = std::move(read);
}

Result<void> ObjectReader::finish() {
  if (error_) return fail(*error_);
  for (const auto& item : json_.items()) {
    if (std::find(known_.begin(), known_.end(), item.key()) != known_.end()) continue;
    const auto nearest = nearest_name(item.key(), known_).value_or("");
    fault(item.key(), "unknown key; " + suggestion(nearest, known_));
    error_->nearest = nearest;
    return fail(*error_);
  }
  if (missing_) return fail(*missing_);
  return {};
}

}  // namespace ovws
