#include "daemon/ovws/text/params.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <iterator>

#include "daemon/ovws/text/mode_names.hpp"
#include "proto/json_text.hpp"
#include "proto/reader.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

/// The schema with its $ref replaced, and only the first of its alternatives.
json resolved(const json& schema, const json& root) {
  if (schema.contains("$ref")) {
    const std::string name = schema.at("$ref").get<std::string>();
    const json defs = root.value("$defs", json::object());
    json target = defs.value(name.substr(name.rfind('/') + 1), json::object());
    if (schema.contains("description")) target["description"] = schema.at("description");
    return target;
  }
  if (!schema.contains("anyOf")) return schema;
  json found = resolved(schema.at("anyOf").at(0), root);
  if (schema.contains("description")) found["description"] = schema.at("description");
  return found;
}

bool has_type(const json& schema, const char* type) {
  const json types = schema.value("type", json());
  if (types.is_string()) return types == type;
  return std::find(types.begin(), types.end(), type) != types.end();
}

bool accepts_number(const json& schema) {
  return has_type(schema, "number") || has_type(schema, "integer");
}

std::vector<std::string> choices_of(const json& schema) {
  std::vector<std::string> all;
  for (const json& value : schema.value("enum", json::array())) {
    if (value.is_string()) all.push_back(value.get<std::string>());
  }
  return all;
}

/// The only form of a mode list's items that has the index j.
json mode_item(const json& schema) {
  const json items = schema.value("items", json::object());
  for (const json& one : items.value("oneOf", json::array({items}))) {
    const json properties = one.value("properties", json::object());
    if (properties.contains("j") && properties.size() == 2) return one;
  }
  return {};
}

tl::unexpected<Error> mistake(const std::string& key, const std::string& reason) {
  return fail(Errc::invalid, key, reason);
}

std::string near_text(const std::string& name, const std::vector<std::string>& known) {
  const auto near = nearest_name(name, known);
  return near ? fmt::format("; did you mean {}?", *near) : "";
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == at) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

tl::unexpected<Error> wrong_value(const std::string& key, const json& schema,
                                  const std::string& text) {
  return mistake(key, fmt::format("must be {}, not \"{}\"{}", expected_of(schema), text,
                                  near_text(text, choices_of(schema))));
}

Result<json> value_of(const std::string& key, const json& schema, const std::string& text);

/// A JSON array, or its items separated by commas. Integers of a key `modes` may be names.
Result<json> list_of(const std::string& key, const json& schema, const std::string& text) {
  if (text.starts_with('[')) {
    json value = json_of(text);
    return value.is_array() ? Result<json>(std::move(value)) : wrong_value(key, schema, text);
  }
  const json items = schema.value("items", json::object());
  if (has_type(items, "object") || items.contains("oneOf") || items.contains("$ref")) {
    return wrong_value(key, schema, text);
  }
  json list = json::array();
  for (const std::string& part : split(text, ',')) {
    if (key == "modes") {
      const auto j = mode_of(part);
      if (!j) return fail(j.error());
      list.push_back(*j);
      continue;
    }
    auto value = value_of(key, items, part);
    if (!value) return wrong_value(key, schema, text);
    list.push_back(std::move(*value));
  }
  return list;
}

/// JSON, or else the text as it is.
json free_value(const std::string& text) {
  json value = json_of(text);
  return value.is_discarded() ? json(text) : value;
}

Result<json> value_of(const std::string& key, const json& schema, const std::string& text) {
  if (schema == any_params()) return free_value(text);
  if (has_type(schema, "null") && text == "null") return json();
  if (has_type(schema, "array")) return list_of(key, schema, text);
  if (has_type(schema, "string")) {
    const auto choices = choices_of(schema);
    const bool is_allowed =
        choices.empty() || std::find(choices.begin(), choices.end(), text) != choices.end();
    return is_allowed ? Result<json>(text) : wrong_value(key, schema, text);
  }
  json value = json_of(text);
  const bool is_whole = value.is_number() && value.get<double>() == std::round(value.get<double>());
  const bool fits = (has_type(schema, "boolean") && value.is_boolean()) ||
                    (has_type(schema, "number") && value.is_number()) ||
                    (has_type(schema, "integer") && is_whole) ||
                    (has_type(schema, "object") && value.is_object());
  return fits ? Result<json>(std::move(value)) : wrong_value(key, schema, text);
}

tl::unexpected<Error> unknown_key(const std::string& key, const json& schema) {
  std::vector<std::string> known;
  for (const ParamsKey& one : keys_of(schema)) known.push_back(one.path);
  if (known.empty()) return mistake(key, "unknown key: the method has no keys");
  const std::string near = near_text(key, known);
  return mistake(key, fmt::format("unknown key{} keys: {}", near.empty() ? ";" : near,
                                  fmt::join(known, ", ")));
}

/// Sets MODE=NUMBER in a list of modes.
Result<void> set_mode(const std::string& key, const json& schema, const std::string& mode,
                      const std::string& text, json& list) {
  const auto j = mode_of(mode);
  if (!j) return fail(j.error());
  if (!list.is_array()) list = json::array();
  const json item = mode_item(schema);
  json one{{"j", *j}};
  for (const auto& [name, value_schema] : item.at("properties").items()) {
    if (name == "j") continue;
    auto value = value_of(key, value_schema, text);
    if (!value) return fail(value.error());
    one[name] = std::move(*value);
  }
  const auto same = std::find_if(list.begin(), list.end(), [&](const json& other) {
    return other.is_object() && other.value("j", json()) == json(*j);
  });
  if (same != list.end()) {
    *same = std::move(one);
  } else {
    list.push_back(std::move(one));
  }
  return {};
}

/// A value of the first of the schema's alternatives that the text fits.
Result<json> value_of_any(const std::string& key, const json& schema, const json& root,
                          const std::string& text) {
  const json alternatives = schema.value("anyOf", json::array({schema}));
  auto first = value_of(key, resolved(alternatives.at(0), root), text);
  for (std::size_t k = 1; !first && k < alternatives.size(); ++k) {
    if (auto other = value_of(key, resolved(alternatives.at(k), root), text)) return other;
  }
  return first;
}

Result<void> put_param(json& params, const json& root, const std::string& key,
                       const std::string& text) {
  json* at = &params;
  json schema = root, as_given = root;
  std::size_t begin = 0;
  for (const std::string& part : split(key, '.')) {
    if (is_mode_list(schema)) return set_mode(key, schema, key.substr(begin), text, *at);
    begin += part.size() + 1;
    const json properties = schema.value("properties", json::object());
    const bool is_free = schema == any_params();
    if (!is_free && !properties.contains(part)) return unknown_key(key, root);
    if (at->is_array()) return mistake(key, "is in an array: give the whole array as JSON");
    if (!at->is_object()) *at = json::object();
    at = &(*at)[part];
    if (is_free) continue;
    as_given = properties.at(part);
    schema = resolved(as_given, root);
    if (schema.contains("items")) schema["items"] = resolved(schema.at("items"), root);
  }
  auto value = as_given.contains("anyOf") ? value_of_any(key, as_given, root, text)
                                          : value_of(key, schema, text);
  if (!value) return fail(value.error());
  *at = std::move(*value);
  return {};
}

Result<std::string> text_of_file(const std::string& path) {
  std::ifstream file(path);
  std::string text;
  std::getline(file, text, '\0');  // unlike an iterator, it does not throw for a folder
  if (!file.is_open() || file.bad()) return mistake(path, "cannot be read");
  return text;
}

Result<std::string> text_of_input() {
  return std::string{std::istreambuf_iterator<char>(std::cin), {}};
}

Result<void> put_object(json& params, const std::string& origin, const Result<std::string>& text) {
  if (!text) return fail(text.error());
  const json object = json_of(*text);
  if (!object.is_object()) return mistake(origin, "the parameters are not a JSON object");
  params.update(object, true);
  return {};
}

Result<void> put_word(json& params, const json& root, const std::string& word) {
  if (word.empty()) return {};
  if (word == "-") return put_object(params, "standard input", text_of_input());
  if (word.starts_with('@')) {
    return put_object(params, word.substr(1), text_of_file(word.substr(1)));
  }
  if (word.find_first_not_of(" \t\n") == word.find_first_of("{[")) {
    return put_object(params, word, word);
  }
  const auto equals = word.find('=');
  if (equals != std::string::npos && equals > 0) {
    return put_param(params, root, word.substr(0, equals), word.substr(equals + 1));
  }
  return mistake(word, "give KEY=VALUE, a JSON object, @FILE, or - for standard input");
}

}  // namespace

const json& any_params() {
  static const json schema{{"type", "object"}, {"additionalProperties", true}};
  return schema;
}

bool is_mode_list(const json& schema) {
  return has_type(schema, "array") && !mode_item(schema).is_null();
}

std::vector<ParamsKey> keys_of(const json& params_schema) {
  std::vector<ParamsKey> all;
  const json required = params_schema.value("required", json::array());
  const json properties = params_schema.value("properties", json::object());
  for (const auto& [name, raw] : properties.items()) {
    json schema = resolved(raw, params_schema);
    for (json whole : raw.value("anyOf", json::array())) {  // beside its keys the whole list
      if (!has_type(whole, "array")) continue;
      whole["description"] = raw.value("description", std::string());
      whole["type"] = json::array({"array", "null"});
      all.push_back({name, std::move(whole), false});
    }
    if (has_type(schema, "object") && schema.contains("properties")) {
      for (ParamsKey& inner : keys_of(schema)) {
        all.push_back({name + "." + inner.path, std::move(inner.schema), false});
      }
      continue;
    }
    if (schema.contains("items")) schema["items"] = resolved(schema.at("items"), params_schema);
    const bool must = std::find(required.begin(), required.end(), name) != required.end();
    all.push_back({name, std::move(schema), must});
  }
  return all;
}

std::string expected_of(const json& schema) {
  std::string text = "a JSON value";
  const auto choices = choices_of(schema);
  if (!choices.empty()) {
    text = fmt::format("one of {}", fmt::join(choices, ", "));
  } else if (has_type(schema, "boolean")) {
    text = "true or false";
  } else if (has_type(schema, "string")) {
    text = "text";
  } else if (has_type(schema, "array")) {
    text = "a list";
  } else if (accepts_number(schema)) {
    text = has_type(schema, "integer") ? "a whole number" : "a number";
    if (schema.contains("minimum") && schema.contains("maximum")) {
      text += fmt::format(" from {} to {}", schema.at("minimum").get<double>(),
                          schema.at("maximum").get<double>());
    }
  }
  if (is_mode_list(schema)) text = "a JSON list of modes; or give NAME.MODE=NUMBER for each mode";
  return has_type(schema, "null") ? text + ", or null" : text;
}

Result<json> params_of(const json& params_schema, const std::vector<std::string>& words) {
  json params = json::object();
  for (const std::string& word : words) {
    if (auto done = put_word(params, params_schema, word); !done) return fail(done.error());
  }
  return params;
}

}  // namespace ovws::cli
