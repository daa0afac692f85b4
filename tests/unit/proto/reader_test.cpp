#include "proto/reader.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "proto/strict_json.hpp"

namespace ovws {
namespace {

using nlohmann::json;

Error first_error(ObjectReader& reader) {
  const auto done = reader.finish();
  EXPECT_FALSE(done);
  return done ? Error{} : done.error();
}

TEST(NearestName, FindsTheNameThatWasMisspelt) {
  const std::vector<std::string> known{"gain_db", "exposure_us", "frame_rate_hz", "roi"};
  EXPECT_EQ(nearest_name("exposure_su", known), "exposure_us");  // letters swapped
  EXPECT_EQ(nearest_name("exposure", known), "exposure_us");     // without unit
  EXPECT_EQ(nearest_name("gain", known), "gain_db");
  EXPECT_EQ(nearest_name("Gain_dB", known), "gain_db");  // case
  EXPECT_EQ(nearest_name("frame_rate_hertz", known), "frame_rate_hz");
  EXPECT_EQ(nearest_name("rio", known), "roi");
}

TEST(NearestName, IsNoneIfNoNameIsSimilar) {
  const std::vector<std::string> known{"gain_db", "roi", "x"};
  EXPECT_EQ(nearest_name("temperature", known), std::nullopt);
  EXPECT_EQ(nearest_name("y", known), std::nullopt);
  EXPECT_EQ(nearest_name("", known), std::nullopt);
  EXPECT_EQ(nearest_name(std::string(1000000, 'a'), known), std::nullopt);
  EXPECT_EQ(nearest_name("gain_db", {}), std::nullopt);
}

TEST(ObjectReader, ReadsEveryKindAndLeavesAbsentKeysAlone) {
  const json object = json::parse(R"({"d": 1.5, "i": 7.0, "b": true, "s": "text", "o": null,
    "c": "two", "v": [1, 2], "inner": {"k": 3}, "list": [{"k": 1}, {"k": 2}]})");
  double d = 0, absent = 42;
  int i = 0, c = -1, k = 0, sum = 0;
  bool b = false;
  std::string s;
  std::vector<double> v;
  ObjectReader r(object, "");
  r.number("d", d, 0, 2);
  r.number("absent", absent, 0, 1);
  r.integer("i", i, 0, 10);
  r.boolean("b", b);
  r.string("s", s);
  EXPECT_TRUE(r.is_null("o"));
  r.choice("c", c, {"one", "two"});
  r.numbers("v", v, 2, 2, 0, 5);
  r.object("inner", [&](ObjectReader& in) { in.integer("k", k, 0, 5); });
  r.objects("list", 2, [&](ObjectReader& in, std::size_t) {
    int one = 0;
    in.integer("k", one, 0, 5);
    sum += one;
  });
  ASSERT_TRUE(r.finish());
  EXPECT_EQ(d, 1.5);
  EXPECT_EQ(absent, 42);
  EXPECT_EQ(i, 7);
  EXPECT_TRUE(b);
  EXPECT_EQ(s, "text");
  EXPECT_EQ(c, 1);
  EXPECT_EQ(v, (std::vector<double>{1, 2}));
  EXPECT_EQ(k, 3);
  EXPECT_EQ(sum, 3);
}

TEST(ObjectReader, NamesThePathAndTheLimitsOfANumberOutOfRange) {
  const json object{{"roi", {{"width", 0}}}};
  int width = 5;
  ObjectReader r(object, "camera");
  r.object("roi", [&](ObjectReader& in) { in.integer("width", width, 1, 65535); });
  const Error error = first_error(r);
  EXPECT_EQ(error.code, Errc::invalid);
  EXPECT_EQ(error.field, "camera.roi.width");
  EXPECT_EQ(error.reason, "must be a whole number from 1 to 65535, not 0");
  EXPECT_EQ(error.min, 1);
  EXPECT_EQ(error.max, 65535);
  EXPECT_EQ(width, 5);
}

TEST(ObjectReader, RefusesWrongTypes) {
  const json object{{"a", "3"}, {"b", 1}, {"c", 2.5}, {"d", {1, "x"}}, {"e", nullptr}};
  const auto refused = [&object](auto read) {
    ObjectReader r(object, "");
    read(r);
    return first_error(r).field;
  };
  double d = 0;
  int i = 0;
  bool b = false;
  std::string s;
  std::vector<double> v;
  EXPECT_EQ(refused([&](ObjectReader& r) { r.number("a", d, 0, 9); }), "a");
  EXPECT_EQ(refused([&](ObjectReader& r) { r.boolean("b", b); }), "b");
  EXPECT_EQ(refused([&](ObjectReader& r) { r.integer("c", i, 0, 9); }), "c");
  EXPECT_EQ(refused([&](ObjectReader& r) { r.numbers("d", v, 2, 2, 0, 9); }), "d[1]");
  EXPECT_EQ(refused([&](ObjectReader& r) { r.string("e", s); }), "e");
  EXPECT_EQ(refused([&](ObjectReader& r) { r.number("e", d, 0, 9); }), "e");
  EXPECT_EQ(refused([&](ObjectReader& r) { r.choice("b", i, {"one"}); }), "b");
  EXPECT_EQ(refused([&](ObjectReader& r) { r.object("a", [](ObjectReader&) {}); }), "a");
}

TEST(ObjectReader, NamesAnUnknownKeyAndWhatWasMeant) {
  const json object{{"exposure_su", 5}};
  double exposure_us = 0;
  ObjectReader r(object, "camera");
  r.number("exposure_us", exposure_us, 0, 10);
  const Error error = first_error(r);
  EXPECT_EQ(error.field, "camera.exposure_su");
  EXPECT_EQ(error.reason, "unknown key; did you mean \"exposure_us\"?");
  EXPECT_EQ(error.nearest, "exposure_us");
}

TEST(ObjectReader, SaysWhatIsKnownIfNothingIsNear) {
  const json object{{"colour", "red"}};
  bool b = false;
  ObjectReader r(object, "");
  r.boolean("b", b);
  EXPECT_EQ(first_error(r).reason, "unknown key; known are \"b\"");
}

TEST(ObjectReader, NamesAnUnknownChoiceAndWhatWasMeant) {
  const json object{{"grid", "hexagon"}};
  int grid = 0;
  ObjectReader r(object, "");
  r.choice("grid", grid, {"hexagonal", "square"});
  const Error error = first_error(r);
  EXPECT_EQ(error.field, "grid");
  EXPECT_EQ(error.nearest, "hexagonal");
}

TEST(ObjectReader, KeepsTheFirstFault) {
  const json object{{"a", 11}, {"b", 12}};
  int value = 0;
  ObjectReader r(object, "");
  r.integer("a", value, 0, 10);
  r.integer("b", value, 0, 10);
  EXPECT_EQ(first_error(r).field, "a");
}

TEST(ObjectReader, ReportsWhatIsMissing) {
  const json object = json::object();
  ObjectReader r(object, "in");
  r.require("pattern");
  const Error error = first_error(r);
  EXPECT_EQ(error.field, "in.pattern");
  EXPECT_EQ(error.reason, "is missing");
}

TEST(ObjectReader, ReportsAMisspeltKeyRatherThanTheMissingOne) {
  const json object{{"patern", "flat"}};
  std::string pattern;
  ObjectReader r(object, "");
  r.require("pattern");
  r.string("pattern", pattern);
  EXPECT_TRUE(r.failed());
  EXPECT_EQ(first_error(r).nearest, "pattern");
}

TEST(ObjectReader, WritesLimitsAsAPersonDoes) {
  const json object{{"frames", 1000000}};
  int frames = 0;
  ObjectReader r(object, "");
  r.integer("frames", frames, 1, 100000);
  EXPECT_EQ(first_error(r).reason, "must be a whole number from 1 to 100000, not 1000000");
}

TEST(ObjectReader, ClampsIfAsked) {
  const json object{{"a", 1e300}, {"b", -5}, {"in", {{"c", 99}}}};
  double a = 0;
  int b = 3, c = 0;
  ObjectReader r(object, "");
  r.clamp(true);
  r.number("a", a, 0, 10);
  r.integer("b", b, -2, 2);
  r.object("in", [&](ObjectReader& in) { in.integer("c", c, 0, 7); });
  ASSERT_TRUE(r.finish());
  EXPECT_EQ(a, 10);
  EXPECT_EQ(b, -2);
  EXPECT_EQ(c, 7);
}

TEST(ObjectReader, RefusesWhatIsNotAnObject) {
  for (const char* text : {"[]", "3", "null", "\"x\""}) {
    const json value = json::parse(text);
    ObjectReader r(value, "camera");
    double d = 0;
    r.number("gain_db", d, 0, 1);
    r.require("gain_db");
    EXPECT_FALSE(r.has("gain_db"));
    EXPECT_EQ(first_error(r).field, "camera") << text;
  }
}

TEST(ObjectReader, RefusesNumbersThatAreNotFinite) {
  const json object{{"a", std::numeric_limits<double>::infinity()},
                    {"b", std::numeric_limits<double>::quiet_NaN()}};
  double a = 0;
  ObjectReader r(object, "");
  r.clamp(true);
  r.number("b", a, 0, 1);
  EXPECT_EQ(first_error(r).field, "b");
}

std::string fault_of(const std::string& text) {
  const auto read = parse_strict_json(text, 4, JsonComments::allowed);
  return read ? "" : read.error().reason;
}

TEST(StrictJson, NamesLineAndColumnOfASyntaxError) {
  EXPECT_EQ(fault_of("{\n  \"a\": 1,\n  \"b\" 2\n}").find("not JSON at line 3, column 7: "), 0U);
  EXPECT_EQ(fault_of("[1, x]").find("not JSON at line 1, column 5: "), 0U);
  EXPECT_EQ(fault_of("{\"a\": 1\n").find("not JSON at line 2, column 1: "), 0U);
  EXPECT_EQ(fault_of("// one\n[\"\u00b5\", x]").find("not JSON at line 2, column 7: "), 0U);
  EXPECT_EQ(fault_of(std::string("[\n\0]", 4)), "not JSON at line 2, column 1: a NUL byte");
}

TEST(StrictJson, NamesTheLineOfAKeyGivenTwice) {
  EXPECT_EQ(fault_of("{\"a\": 1,\n /* \n */ \"b\": {\"a\": 2},\n  \"a\"\n: 3}"),
            "the key \"a\" is given twice in one object, the second time in line 4");
}

}  // namespace
}  // namespace ovws
