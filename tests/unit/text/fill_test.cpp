#include "daemon/ovws/text/fill.hpp"

#include <gtest/gtest.h>

namespace ovws::cli {
namespace {

using nlohmann::json;

TEST(Fill, PutsValuesInTheirFormat) {
  const json values{{"a", 1}, {"b", {{"c", 0.25}}}, {"d", {1.5, 2}}, {"e", "x"}, {"f", nullptr}};
  EXPECT_EQ(
      fill("{a} {a:.2f} {b.c:.1f} {b.c*100:.0f} % {a/4:.2f} {d.0} {d.1} {e} {e:>3} {f}", values),
      "1 1.00 0.2 25 % 0.25 1.5 2 x   x ?");
  EXPECT_EQ(fill("{d:list}; {d:count}; {b:json}", values), "1.5, 2; 2; {\"c\":0.25}");
  EXPECT_THROW(fill("{missing}", values), json::exception);
  EXPECT_THROW(fill("{b.missing:.1f}", values), json::exception);
  EXPECT_THROW(fill("{b}", values), json::exception);
}

TEST(Fill, SaysWhatHolds) {
  const json values{{"yes", true},     {"no", false},      {"zero", 0},   {"empty", json::array()},
                    {"none", nullptr}, {"state", "ended"}, {"list", {1}}, {"text", ""}};
  EXPECT_EQ(fill("[yes?y][no?n][zero?z][empty?e][none?o][list?l][text?t][missing?m]", values),
            "yl");
  EXPECT_EQ(fill("[!yes?y][!no?n][!missing?m]", values), "nm");
  EXPECT_EQ(fill("[state=ended?a][state=off?b][!state=off?c][no=false?d][no|yes?e]", values),
            "acde");
  EXPECT_EQ(fill("[no?{missing}[yes?in]][yes?[no?not][yes?nested]]", values), "nested");
}

TEST(Fill, RepeatsForTheItemsOfAList) {
  const json values{{"all", {{{"name", "a"}, {"on", true}}, {{"name", "b"}, {"on", false}}}},
                    {"no", json::array()}};
  EXPECT_EQ(fill("[all*{name}[on? (on)]\n][no*x][!no?no more]", values), "a (on)\nb\nno more");
  EXPECT_EQ(fill("[all*{name}\n]", values), "a\nb");
}

}  // namespace
}  // namespace ovws::cli
