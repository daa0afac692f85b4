/// JSON text of bytes that a device may send, and text that is not JSON.
#include "proto/json_text.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace ovws {
namespace {

using nlohmann::json;

TEST(JsonText, IsOneLineOrIndented) {
  const json value{{"a", {1, 2}}, {"b", nullptr}};
  EXPECT_EQ(json_text(value), R"({"a":[1,2],"b":null})");
  EXPECT_EQ(json_text(json{{"a", 1}}, 2), "{\n  \"a\": 1\n}");
  EXPECT_EQ(json_of(json_text(value, 1)), value);
}

TEST(JsonText, ReplacesBytesThatAreNotUtf8) {
  EXPECT_EQ(json_text("camera \xff\xc3"), "\"camera \xef\xbf\xbd\xef\xbf\xbd\"");
}

TEST(JsonText, IsDiscardedIfItIsNotJson) {
  for (const char* text : {"", "{", "1 2", "{\"a\": }", "nul"}) {
    EXPECT_TRUE(json_of(text).is_discarded()) << text;
  }
  EXPECT_THROW((void)json_of("{").at("a"), json::type_error);
}

}  // namespace
}  // namespace ovws
