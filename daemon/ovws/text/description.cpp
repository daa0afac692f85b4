#include "daemon/ovws/text/description.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "core/optics/zernike.hpp"
#include "daemon/ovws/text/mode_names.hpp"
#include "daemon/ovws/text/params.hpp"
#include "proto/json_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

const std::string kStream = "stream.";

std::string group_of(const std::string& name) {
  return name.substr(0, name.find('.'));
}

std::string row(const std::string& name, const std::string& text) {
  if (name.size() >= kDescriptionColumn) return name + "\n" + row("", text);
  return fmt::format("{:<{}}{}\n", name, kDescriptionColumn, text);
}

std::string key_lines(const ParamsKey& key) {
  std::string expected = expected_of(key.schema);
  if (is_mode_list(key.schema)) expected = fmt::format("list of modes: {}.MODE=NUMBER", key.path);
  if (key.required) expected += ", required";
  if (key.schema.contains("default")) {
    expected += ", default " + json_text(key.schema.at("default"));
  }
  return row("  " + key.path, expected) + row("", key.schema.value("description", std::string()));
}

std::string mode_word(const json& mode) {
  const int j = mode.contains("j") ? mode.at("j").get<int>()
                                   : osa_index({mode.at("n").get<int>(), mode.at("m").get<int>()});
  return j < int(mode_names().size()) ? mode_names()[std::size_t(j)] : std::to_string(j);
}

bool is_modes(const json& value) {
  if (!value.is_array() || value.empty()) return false;
  const json& first = value.front();
  return first.is_object() && (first.contains("j") || (first.contains("n") && first.contains("m")));
}

void add_words(std::vector<std::string>& words, const std::string& prefix, const json& object) {
  for (const auto& [key, value] : object.items()) {
    const std::string path = prefix + key;
    if (value.is_object()) {
      add_words(words, path + ".", value);
    } else if (is_modes(value)) {
      for (const json& mode : value) {
        const json& number = mode.contains("waves") ? mode.at("waves") : mode.at("gain");
        words.push_back(fmt::format("{}.{}={}", path, mode_word(mode), json_text(number)));
      }
    } else {
      const std::string text = value.is_string() ? value.get<std::string>() : json_text(value);
      const bool is_quoted =
          (value.is_array() && (value.empty() || !value.front().is_primitive())) ||
          text.find_first_of("<>") != std::string::npos;
      words.push_back(is_quoted          ? fmt::format("'{}={}'", path, text)
                      : value.is_array() ? path + "=" + text.substr(1, text.size() - 2)
                                         : path + "=" + text);
    }
  }
}

std::string method_text(const std::string& name, const json& method) {
  const json& params = method.at("params");
  std::string text = row(name, method.value("description", std::string()));
  const auto keys = keys_of(params);
  text += keys.empty() ? "\nno keys\n" : "\nkeys\n";
  for (const ParamsKey& key : keys) text += key_lines(key);
  text += "\nexample\n";
  for (const json& example : params.value("examples", json::array({json::object()}))) {
    text += "  ovws call " + name + words_of_params(example) + "\n";
  }
  std::string result;
  for (const json& key : method.at("result").value("required", json::array())) {
    result += (result.empty() ? "" : ", ") + key.get<std::string>();
  }
  text += "\n" + row("result", result);
  if (method.contains("binary_params")) {
    text += row("binary frame", "after the request's JSON, which ovws call cannot send: " +
                                    method.at("binary_params").get<std::string>());
  }
  if (method.contains("binary_result")) {
    text += row("binary frame", "after the result's JSON, which ovws call does not print: " +
                                    method.at("binary_result").get<std::string>());
  }
  return text;
}

std::string stream_text(const std::string& name, const json& stream) {
  std::string text = row(name, stream.value("description", std::string())) + "\nkeys\n";
  const json properties = stream.value("properties", json::object());
  for (const auto& [key, schema] : properties.items()) {
    text += row("  " + key, schema.value("description", std::string()));
  }
  return text;
}

}  // namespace

std::string list_text(const json& description) {
  std::string text, group;
  for (const auto& [name, method] : description.at("methods").items()) {
    if (!group.empty() && group != group_of(name)) text += "\n";
    group = group_of(name);
    text += row(name, method.value("description", std::string()));
  }
  text += "\n";
  for (const auto& [name, stream] : description.at("streams").items()) {
    text += row("stream " + name, stream.value("description", std::string()));
  }
  return text + "\novws describe NAME shows the keys of one of them, with ranges and examples.\n";
}

json entry_of(const json& description, const std::string& name) {
  const json& methods = description.at("methods");
  if (methods.contains(name)) return methods.at(name);
  const std::string topic = name.starts_with(kStream) ? name.substr(kStream.size()) : name;
  const json& streams = description.at("streams");
  return streams.contains(topic) ? streams.at(topic) : json();
}

std::string entry_text(const json& description, const std::string& name) {
  const json entry = entry_of(description, name);
  if (entry.is_null()) return "";
  return entry.contains("params") ? method_text(name, entry) : stream_text(name, entry);
}

std::vector<std::string> entry_names(const json& description) {
  std::vector<std::string> names;
  for (const char* kind : {"methods", "streams"}) {
    for (const auto& [name, entry] : description.at(kind).items()) names.push_back(name);
  }
  return names;
}

std::string words_of_params(const json& params) {
  std::vector<std::string> words;
  add_words(words, "", params);
  return words.empty() ? "" : " " + fmt::format("{}", fmt::join(words, " "));
}

}  // namespace ovws::cli
