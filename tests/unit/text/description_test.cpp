#include "daemon/ovws/text/description.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "daemon/ovws/text/params.hpp"
#include "daemon/shared/schemas/schemas.hpp"
#include "tests/unit/text/expect_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;

json description() {
  json all{{"methods", json::object()}, {"streams", json::object()}};
  for (const Schema& one : schemas()) {
    if (one.json.contains("params")) {
      all["methods"][one.name] = one.json;
    } else {
      all["streams"][one.name.substr(one.name.find('.') + 1)] = one.json;
    }
  }
  return all;
}

TEST(Description, TheListIsGrouped) {
  const std::string text = list_text(description());
  expect_text(text, "aberration.set        Replaces the introduced aberration.");
  expect_text(text, "\n\ncalibration.clear ");
  expect_text(text, "stream wavefront ");
}

TEST(Description, AMethodHasItsKeysWithRangesAndExamples) {
  const std::string text = entry_text(description(), "camera.set");
  expect_text(text, "camera.set            Changes camera settings");
  expect_text(text, "  exposure_us         a number from 0.1 to 60000000\n");
  expect_text(text, "  roi.width           a whole number from 1 to 65535\n");
  expect_text(text, "  clamp               true or false, default false\n");
  expect_text(text, "  ovws call camera.set exposure_us=1500 frame_rate_hz=200\n");
  expect_text(text, "result                requested, applied, limits\n");
  expect_text(entry_text(description(), "aberration.set"), "modes.MODE=NUMBER, required");
  expect_text(entry_text(description(), "camera.get"), "no keys");
}

TEST(Description, AStreamHasTheKeysOfItsMessages) {
  expect_text(entry_text(description(), "wavefront"), "  rms_waves ");
  expect_text(entry_text(description(), "wavefront"), "  reference_introduced_rms_waves\n   ");
  EXPECT_EQ(entry_of(description(), "stream.wavefront"), entry_of(description(), "wavefront"));
  EXPECT_EQ(entry_text(description(), "nothing"), "");
}

TEST(Description, EveryExampleCanBeTyped) {
  for (const Schema& one : schemas()) {
    if (!one.json.contains("params")) continue;
    for (const json& example : one.json.at("params").at("examples")) {
      const std::string text = words_of_params(example);
      std::vector<std::string> words;
      std::istringstream stream(text);
      if (text.find('\'') != std::string::npos) {
        words = {text.substr(2, text.rfind('\'') - 2)};
        if (text.find('\'', 2) != text.rfind('\'') || text[1] != '\'') continue;
      } else {
        for (std::string word; stream >> word;) words.push_back(word);
      }
      EXPECT_TRUE(params_of(one.json.at("params"), words)) << one.name << text;
    }
  }
}

}  // namespace
}  // namespace ovws::cli
