#include "daemon/ovws/text/params.hpp"

#include <gtest/gtest.h>

#include "daemon/shared/schemas/schemas.hpp"
#include "tests/unit/text/expect_text.hpp"

namespace ovws::cli {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

json params(const char* method, const Words& words) {
  const auto got = params_of(schema(method).at("params"), words);
  EXPECT_TRUE(got) << text_of(got.error());
  return got.value_or(json());
}

std::string refusal(const char* method, const std::string& word) {
  const auto got = params_of(schema(method).at("params"), {word});
  EXPECT_FALSE(got) << word;
  return got ? "" : text_of(got.error());
}

TEST(Params, DotsNestAndTheSchemaGivesTheType) {
  EXPECT_EQ(params("camera.set", {"exposure_us=2e3", "roi.width=512", "roi.x=0", "clamp=true",
                                  "pixel_format=Mono8", "gain_db=null"}),
            json::parse(R"({"exposure_us": 2000.0, "roi": {"width": 512, "x": 0}, "clamp": true,
                            "pixel_format": "Mono8", "gain_db": null})"));
  EXPECT_EQ(params("record.start", {"name=12"}), json({{"name", "12"}}));
  EXPECT_EQ(params("record.start", {"name=a=b"}), json({{"name", "a=b"}}));
}

TEST(Params, ListsAreWrittenWithCommasOrAsJson) {
  EXPECT_EQ(params("sensor.set", {"grooves=200,-20.5"}),
            json::parse(R"({"grooves": [200, -20.5]})"));
  EXPECT_EQ(params("sensor.set", {"grooves=[200, 20]"}), json::parse(R"({"grooves": [200, 20]})"));
  EXPECT_EQ(params("loop.close", {"modes=3,defocus"}), json::parse(R"({"modes": [3, 4]})"));
}

TEST(Params, AValueMayBeAnyOfItsAlternatives) {
  EXPECT_EQ(params("sensor.set", {"mask=null"}), json::parse(R"({"mask": null})"));
  EXPECT_EQ(params("sensor.set", {R"(mask={"axicon_waves": 0.1})"}),
            json::parse(R"({"mask": {"axicon_waves": 0.1}})"));
  EXPECT_EQ(params("sensor.set", {"mask.axicon_waves=0.1"}),
            json::parse(R"({"mask": {"axicon_waves": 0.1}})"));
  EXPECT_EQ(params("sensor.set", {R"(mask=[{"axicon_waves": 0.1}, {}])"}),
            json::parse(R"({"mask": [{"axicon_waves": 0.1}, {}]})"));
  expect_text(refusal("sensor.set", "mask=0.1"), "mask: must be");
  expect_text(refusal("sensor.set", "maks=null"), "did you mean mask?");
  EXPECT_FALSE(params_of(schema("sensor.set").at("params"), {"mask=[{}]", "mask.axicon_waves=1"}));
}

TEST(Params, ModesAreAddedByNameAndByNumber) {
  EXPECT_EQ(params("aberration.set", {"modes.vertical-coma=0.2", "modes.4=-0.1", "modes.3,3=0.05"}),
            json::parse(R"({"modes": [{"j": 7, "waves": 0.2}, {"j": 4, "waves": -0.1},
                                      {"j": 9, "waves": 0.05}]})"));
  EXPECT_EQ(params("loop.close", {"gains.defocus=0.2", "offsets.8=0.01"}),
            json::parse(R"({"gains": [{"j": 4, "gain": 0.2}],
                            "offsets": [{"j": 8, "waves": 0.01}]})"));
  EXPECT_EQ(params("aberration.set", {"modes.7=0.1", "modes.vertical-coma=0.2"}),
            json::parse(R"({"modes": [{"j": 7, "waves": 0.2}]})"));
  expect_text(refusal("aberration.set", "modes.coma=0.2"), "vertical-coma or horizontal-coma");
  expect_text(refusal("aberration.set", "modes.3.1=0.2"), "3.1");
  expect_text(refusal("aberration.set", "modes.defocus=much"), "modes.defocus: must be a number");
}

TEST(Params, LaterWordsOverrideObjects) {
  EXPECT_EQ(params("camera.set", {R"({"gain_db": 1, "exposure_us": 2})", "gain_db=3"}),
            json::parse(R"({"gain_db": 3, "exposure_us": 2})"));
  EXPECT_EQ(params("camera.set", {"roi.height=64", R"({"roi": {"width": 512}})"}),
            json::parse(R"({"roi": {"height": 64, "width": 512}})"));
  EXPECT_EQ(params("camera.set", {}), json::object());
}

TEST(Params, AMistakeNamesTheKeyAndWhatIsAllowed) {
  const std::string unknown = refusal("camera.set", "gian_db=1");
  expect_text(unknown, "gian_db: unknown key; did you mean gain_db?");
  expect_text(unknown, "roi.height, roi.width");
  expect_text(refusal("camera.set", "roi.widht=1"), "did you mean roi.width?");
  expect_text(refusal("camera.set", "exposure_us=2ms"),
              "exposure_us: must be a number from 0.1 to 60000000, not \"2ms\"");
  expect_text(refusal("camera.set", "roi.width=1.5"), "must be a whole number from 1 to 65535");
  expect_text(refusal("camera.set", "clamp=yes"), "must be true or false");
  expect_text(refusal("sensor.set", "tracker=ft"), "lg, fit, not \"ft\"; did you mean fit?");
  expect_text(refusal("sensor.get", "x=1"), "the method has no keys");
  for (const char* word : {"{not json", "[1]", "gain_db", "=1", "12", "@no/such/file", "@/"}) {
    EXPECT_FALSE(refusal("camera.set", word).empty());
  }
}

TEST(Params, EveryExampleOfEveryMethodIsAccepted) {
  for (const Schema& one : schemas()) {
    if (!one.json.contains("params")) continue;
    for (const json& example : one.json.at("params").at("examples")) {
      EXPECT_EQ(params(one.name.c_str(), {example.dump()}), example);
      for (const auto& [key, value] : example.items()) {
        if (value.is_object() || (value.is_array() && !value.empty() && value[0].is_object()))
          continue;
        const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
        EXPECT_EQ(params(one.name.c_str(), {key + "=" + text}), json({{key, value}})) << one.name;
      }
    }
  }
}

}  // namespace
}  // namespace ovws::cli
