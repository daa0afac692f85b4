/// WIRE.md names every parameter of every method, and every key of the results and messages.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "daemon/shared/schemas/schemas.hpp"

namespace ovws {
namespace {

using nlohmann::json;
using Names = std::set<std::string>;

/// WIRE.md without its blocks of code: the cells of each method's row by "METHOD params" and
/// "METHOD result", and the section of each topic by "stream.TOPIC".
std::map<std::string, std::string> documented() {
  std::ifstream file(OVWS_SOURCE_DIR "/proto/WIRE.md");
  const std::regex heading("#{2,3} (\\w+)?:?.*");
  const std::regex row("\\| `([a-z]+\\.[a-z_]+)` \\|([^|]*)\\|([^|]*)\\|");
  std::map<std::string, std::string> texts;
  std::string section;
  bool code = false;
  std::smatch found;
  for (std::string line; std::getline(file, line);) {
    const bool fence = line.rfind("```", 0) == 0;
    if (fence) code = !code;
    if (fence || code) continue;
    if (std::regex_match(line, found, heading)) section = "stream." + found[1].str();
    texts[section] += line + "\n";
    if (!std::regex_match(line, found, row)) continue;
    texts[found[1].str() + " params"] = found[2];
    texts[found[1].str() + " result"] = found[3];
  }
  return texts;
}

class WireKeys : public testing::Test {
 protected:
  /// Adds the names in `code` of a text, and those of the methods and topics that it refers to.
  void add_names(const std::string& text, Names& names) const {
    static const std::regex kCode("`([^`]+)`"), kName("[a-z0-9_]+");
    for (std::sregex_iterator it(text.begin(), text.end(), kCode), end; it != end; ++it) {
      const std::string code = (*it)[1];
      for (std::sregex_iterator at(code.begin(), code.end(), kName); at != end; ++at) {
        names.insert(at->str());
      }
      if (!names.insert(code + "()").second) continue;
      for (const std::string& other : {code + " params", code + " result", "stream." + code}) {
        if (texts_.contains(other)) add_names(texts_.at(other), names);
      }
    }
  }

  static void add_keys(const json& schema, const json& whole, bool nested, Names& keys) {
    if (schema.contains("$ref")) {
      const json::json_pointer path(schema["$ref"].get<std::string>().substr(1));
      return add_keys(whole.at(path), whole, nested, keys);
    }
    const json properties = schema.value("properties", json::object());
    const json variants = schema.value("anyOf", json::array());
    for (const auto& [key, part] : properties.items()) {
      keys.insert(key);
      if (nested) add_keys(part, whole, nested, keys);
    }
    if (nested && schema.contains("items")) add_keys(schema["items"], whole, nested, keys);
    for (const json& one : variants) {
      if (nested) add_keys(one, whole, nested, keys);
    }
  }

  void expect_named(const std::string& where, const json& schema, bool nested) const {
    ASSERT_TRUE(texts_.contains(where)) << where;
    Names names, keys;
    add_names(texts_.at(where), names);
    add_keys(schema, schema, nested, keys);
    for (const std::string& key : keys) EXPECT_TRUE(names.contains(key)) << where << ": " << key;
  }

  const std::map<std::string, std::string> texts_ = documented();
};

TEST_F(WireKeys, EveryParameterAndEveryKeyOfAResultIsInTheMethodsRow) {
  for (const Schema& one : schemas()) {
    if (one.name.rfind("stream.", 0) == 0) continue;
    expect_named(one.name + " params", one.json["params"], true);
    // The keys of the configuration are those of config/README.md.
    if (one.name != "config.get") expect_named(one.name + " result", one.json["result"], false);
  }
}

TEST_F(WireKeys, EveryKeyOfAMessageIsInItsTopicsSection) {
  for (const Schema& one : schemas()) {
    if (one.name.rfind("stream.", 0) == 0) expect_named(one.name, one.json, true);
  }
}

}  // namespace
}  // namespace ovws
