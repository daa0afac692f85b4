#include "daemon/web/trend.hpp"

#include <gtest/gtest.h>

namespace ovws::web {
namespace {

using nlohmann::json;

json frame(std::int64_t t_ms, double coefficient, bool valid = true) {
  json message{{"t_arrival_ns", t_ms * 1'000'000},
               {"gap", 0},
               {"subapertures", 19},
               {"tracked", 19},
               {"latency_us", 100.0},
               {"valid", valid},
               {"rms_waves", nullptr},
               {"j", {1, 2}},
               {"coefficients", {nullptr, nullptr}}};
  if (!valid) return message;
  message["rms_waves"] = coefficient;
  message["coefficients"] = {coefficient, -coefficient};
  return message;
}

TEST(TrendTest, AveragesHalfASecondAndKeepsItsExtremes) {
  Trend trend(kTrendBinNs);
  EXPECT_FALSE(trend.add(frame(10'000, 0.1)));
  json spike = frame(10'100, 0.3);
  spike["latency_us"] = 900.0;
  spike["tracked"] = 17;
  spike["gap"] = 2;
  EXPECT_FALSE(trend.add(spike));
  EXPECT_FALSE(trend.add(frame(10'200, 0.0, false)));
  const auto bin = trend.add(frame(10'510, 5.0));
  ASSERT_TRUE(bin);
  EXPECT_EQ((*bin)["frames"], 3);
  EXPECT_EQ((*bin)["valid"], 2);
  EXPECT_EQ((*bin)["gap"], 2);
  EXPECT_EQ((*bin)["lost_max"], 2);
  EXPECT_EQ((*bin)["latency_max_us"], 900.0);
  EXPECT_EQ((*bin)["latency_median_us"], 100.0);
  EXPECT_DOUBLE_EQ((*bin)["rms_waves"].get<double>(), 0.2);
  EXPECT_DOUBLE_EQ((*bin)["rms_min_waves"].get<double>(), 0.1);
  EXPECT_DOUBLE_EQ((*bin)["rms_max_waves"].get<double>(), 0.3);
  EXPECT_DOUBLE_EQ((*bin)["coefficients"][1].get<double>(), -0.2);
  EXPECT_DOUBLE_EQ((*bin)["span_s"].get<double>(), 0.5);
}

TEST(TrendTest, SaysNothingOfModesThatWereNotMeasured) {
  Trend trend(kTrendBinNs);
  trend.add(frame(0, 0.0, false));
  const auto bin = trend.add(frame(600, 0.1));
  ASSERT_TRUE(bin);
  EXPECT_TRUE((*bin)["rms_waves"].is_null());
  EXPECT_TRUE((*bin)["coefficients"].is_null());
}

TEST(TrendTest, BeginsAnewWithOtherModesOrAnEarlierClock) {
  Trend trend(kTrendBinNs);
  trend.add(frame(1000, 0.9));
  json other = frame(1100, 0.4);
  other["j"] = {1, 2, 3};
  other["coefficients"] = {0.4, 0.4, 0.4};
  trend.add(other);
  const auto bin = trend.add(frame(500, 0.1));
  ASSERT_TRUE(bin);
  EXPECT_EQ((*bin)["j"], (json{1, 2, 3}));
  EXPECT_DOUBLE_EQ((*bin)["rms_waves"].get<double>(), 0.4);
  EXPECT_DOUBLE_EQ((*bin)["rms_max_waves"].get<double>(), 0.4);
  EXPECT_FALSE(trend.add(frame(600, 0.1)));
}

TEST(TrendTest, HasBinsOfTheLengthAskedFor) {
  Trend trend(kHistoryBinNs);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(trend.add(frame(10'000 + 50 * i, 0.001 * i)));
  const auto bin = trend.add(frame(15'000, 0.0));
  ASSERT_TRUE(bin);
  EXPECT_EQ((*bin)["bin_s"], 5.0);
  EXPECT_EQ((*bin)["frames"], 100);
  EXPECT_EQ((*bin)["rms_min_waves"], 0.0);
  EXPECT_DOUBLE_EQ((*bin)["rms_max_waves"].get<double>(), 0.099);
}

TEST(TrendTest, AnHourOfManyModesStaysSmall) {
  constexpr int kModes = 230;
  Trend trend(kHistoryBinNs);
  json full = frame(10'000, 0.1);
  full["j"] = json::array();
  full["coefficients"] = json::array();
  for (int j = 1; j <= kModes; ++j) {
    full["j"].push_back(j);
    full["coefficients"].push_back(-1.0 / (j + 6.0));
  }
  trend.add(full);
  const auto bin = trend.add(frame(20'000, 0.1));
  ASSERT_TRUE(bin);
  EXPECT_LT(bin->dump().size(), 4096U);
}

}  // namespace
}  // namespace ovws::web
