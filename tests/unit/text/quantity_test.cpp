#include "daemon/ovws/text/quantity.hpp"

#include <gtest/gtest.h>

namespace ovws::cli {
namespace {

TEST(Quantity, TimesHaveUnits) {
  EXPECT_DOUBLE_EQ(seconds_of("2ms").value(), 2e-3);
  EXPECT_DOUBLE_EQ(seconds_of("2000 us").value(), 2e-3);
  EXPECT_DOUBLE_EQ(seconds_of("20µs").value(), 2e-5);
  EXPECT_DOUBLE_EQ(seconds_of("1.5h").value(), 5400.0);
  EXPECT_EQ(hertz_of("100 Hz"), 100.0);
  EXPECT_EQ(hertz_of("0.5"), 0.5);
  EXPECT_FALSE(hertz_of("10ms"));
  EXPECT_EQ(seconds_of("2").error().reason, "\"2\" has no unit: give e.g. 2us, 2ms or 2s");
  for (const char* text : {"", "ms", "2 msec", "nan s", "2ms x", "auto"}) {
    EXPECT_FALSE(seconds_of(text)) << text;
  }
}

TEST(Quantity, GainsAreDecibels) {
  EXPECT_DOUBLE_EQ(decibels_of("12").value(), 12.0);
  EXPECT_DOUBLE_EQ(decibels_of("-1.5 dB").value(), -1.5);
  for (const char* text : {"", "dB", "12 x", "inf"}) EXPECT_FALSE(decibels_of(text)) << text;
}

TEST(Quantity, TimesAreWrittenWithTheUnitThatSuits) {
  EXPECT_EQ(time_text(0.0), "0 s");
  EXPECT_EQ(time_text(2e-5), "20 us");
  EXPECT_EQ(time_text(2e-3), "2 ms");
  EXPECT_EQ(time_text(0.9999), "1 s");
  EXPECT_EQ(time_text(59.9), "1 min");
  EXPECT_EQ(time_text(192.0), "3 min 12 s");
  EXPECT_EQ(time_text(7500.0), "2 h 5 min");
  EXPECT_EQ(time_text(3600.0 * 76), "3 d 4 h");
}

TEST(Quantity, SizesAreWrittenWithTheUnitThatSuits) {
  EXPECT_EQ(size_text(812.0), "812 B");
  EXPECT_EQ(size_text(19.89e6), "19.9 MB");
  EXPECT_EQ(size_text(2e12), "2 TB");
}

}  // namespace
}  // namespace ovws::cli
