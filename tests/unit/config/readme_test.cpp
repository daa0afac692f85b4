/// config/README.md lists every key of the configuration with its default, range and names.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "config/tables.hpp"
#include "proto/field_schema.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace {

using NumberRange = std::optional<std::pair<double, double>>;

struct Row {
  std::string preset;  ///< JSON
  std::string range, meaning;
};

std::vector<std::string> split(const std::string& text, const std::string& by) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find(by, begin)) != std::string::npos; begin = end + by.size())
    parts.push_back(text.substr(begin, end - begin));
  parts.push_back(text.substr(begin));
  return parts;
}

std::string without(const std::string& text, const char* characters) {
  return std::regex_replace(text, std::regex(characters), "");
}

/// The rows of the tables by dotted key. A row may describe several keys. Below a heading that is
/// a section of the file, keys are those of the section.
std::map<std::string, Row> documented(const Json& defaults) {
  std::ifstream file(OVWS_SOURCE_DIR "/config/README.md");
  std::map<std::string, Row> rows;
  std::string section;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("## ", 0) == 0) {
      section = defaults.contains(line.substr(3)) ? line.substr(3) + "." : "";
    }
    const auto cells = split(line, "|");
    if (line.rfind("| `", 0) != 0 || cells.size() != 6) continue;
    const auto keys = split(without(cells[1], "[ `]"), ",");
    const std::string all = without(cells[2], "[ `]");
    const auto presets = keys.size() == 1 ? std::vector{all} : split(all, ",");
    for (std::size_t k = 0; k < keys.size() && k < presets.size(); ++k) {
      rows[section + keys[k]] = {presets[k], cells[3], cells[4]};
    }
  }
  return rows;
}

/// "µs, 0.1 to 60 000 000".
NumberRange range_in(const std::string& text) {
  static const std::regex kRange("(-?[0-9][0-9 .e]*) to (-?[0-9][0-9 .e]*)");
  std::smatch found;
  if (!std::regex_search(text, found, kRange)) return std::nullopt;
  return std::pair(std::stod(without(found[1], " ")), std::stod(without(found[2], " ")));
}

NumberRange range_of(const Json& schema) {
  const Json& number = schema.contains("items") ? schema["items"] : schema;
  if (!number.contains("minimum")) return std::nullopt;
  return std::pair(number["minimum"].get<double>(), number["maximum"].get<double>());
}

/// A Bayer format is documented by its pattern and its depth.
bool names(const Row& row, const std::string& name) {
  const std::string text = row.range + row.meaning;
  const auto holds = [&](const std::string& one) {
    return text.find("`" + one + "`") != std::string::npos;
  };
  return holds(name) ||
         (name.rfind("Bayer", 0) == 0 && holds(name.substr(5, 2)) && holds(name.substr(7)));
}

class ConfigReadme : public testing::Test {
 protected:
  /// Calls visit(dotted key, schema, default) for each key below `schema`.
  template <class Visit>
  void each_key(const std::string& key, const Json& schema, const Json& preset, Visit visit) {
    if (schema.contains("$ref")) {
      return each_key(key,
                      whole_.at(Json::json_pointer(schema["$ref"].get<std::string>().substr(1))),
                      preset, visit);
    }
    if (!schema.contains("properties")) return visit(key, schema, preset);
    for (const auto& [name, part] : schema["properties"].items()) {
      if (!preset.contains(name)) continue;  // left out by default: the file does not set it
      each_key(key.empty() ? name : key + "." + name, part, preset.at(name), visit);
    }
  }

  const Json whole_ = schema_of<Config>(SchemaOf::result);
  const Json defaults_ = Json::parse(dump_config(Config{}));
};

TEST_F(ConfigReadme, ListsEveryKeyWithItsDefaultRangeAndNamesAndNoOther) {
  auto rows = documented(defaults_);
  each_key("", whole_, defaults_,
           [&](const std::string& key, const Json& schema, const Json& preset) {
             SCOPED_TRACE(key);
             const auto found = rows.extract(key);
             ASSERT_TRUE(found) << "no row";
             const Row& row = found.mapped();
             EXPECT_EQ(Json::parse(row.preset, nullptr, false), preset);
             EXPECT_EQ(range_in(row.range), range_of(schema)) << row.range;
             for (const Json& name : schema.value("enum", Json::array())) {
               EXPECT_TRUE(name.is_null() || names(row, name)) << name;
             }
           });
  for (const auto& [key, row] : rows) ADD_FAILURE() << key << " is no key of the configuration";
}

/// Every key whose unit is "path".
TEST_F(ConfigReadme, ListsPathsThatStartFromTheFolderOfTheFile) {
  Json file = Json::object();
  std::vector<std::string> keys;
  for (const auto& [key, row] : documented(defaults_)) {
    if (row.range != " path ") continue;
    keys.push_back("/" + std::regex_replace(key, std::regex("[.]"), "/"));
    file[Json::json_pointer(keys.back())] = "some/file";
  }
  EXPECT_GE(keys.size(), 6U);
  const std::string folder = own_folder("config_readme");
  std::filesystem::create_directory(folder);
  std::ofstream(folder + "/ovwsd.json") << file;
  const auto config = load_config(folder + "/ovwsd.json");
  std::filesystem::remove_all(folder);
  ASSERT_TRUE(config) << config.error().reason;
  const Json dumped = Json::parse(dump_config(*config));
  for (const std::string& key : keys) {
    EXPECT_EQ(dumped.at(Json::json_pointer(key)), folder + "/some/file") << key;
  }
}

}  // namespace
}  // namespace ovws
