#include "core/base/number_text.hpp"

#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>

namespace ovws {
namespace {

TEST(NumberText, ReadsWholeFiniteNumbersOnly) {
  EXPECT_EQ(finite_number("1.5"), 1.5);
  EXPECT_EQ(finite_number("-.25e-3"), -0.25e-3);
  EXPECT_EQ(finite_number("+2"), 2.0);
  EXPECT_EQ(finite_number("0"), 0.0);
  for (const char* wrong : {"", "+", "-", "+-1", "++1", "1,5", "1.5 ", " 1.5", "1.5x", "1.5.5",
                            "0x10", "nan", "inf", "-inf", "1e999", "ten"}) {
    EXPECT_EQ(finite_number(wrong), std::nullopt) << wrong;
  }
}

TEST(NumberText, WritesADecimalPoint) {
  EXPECT_EQ(with_decimals(0.5, 2), "0.50");
  EXPECT_EQ(with_decimals(-1234.5678, 3), "-1234.568");
  EXPECT_EQ(with_decimals(7.0, 0), "7");
  EXPECT_EQ(with_decimals(1e308, 6).size(), 309U + 7U);
  EXPECT_EQ(with_digits(0.5, 10), "0.5");
  EXPECT_EQ(with_digits(100000.0, 10), "100000");
  EXPECT_EQ(with_digits(1.0 / 3.0, 4), "0.3333");
  EXPECT_EQ(with_digits(1e20, 10), "1e+20");
}

TEST(NumberText, ZeroHasNoSign) {
  EXPECT_EQ(signed_decimals(0.5, 4), "+0.5000");
  EXPECT_EQ(signed_decimals(-0.00005001, 4), "-0.0001");
  EXPECT_EQ(signed_decimals(-0.00004, 4), "0.0000");
  EXPECT_EQ(signed_decimals(0.00004, 4), "0.0000");
  EXPECT_EQ(signed_decimals(-0.0, 0), "0");
  EXPECT_EQ(signed_decimals(-100.0, 0), "-100");
}

/// Libraries call setlocale(LC_ALL, "") when they like: see core/port/c_locale.cpp.
TEST(CLocale, IsWhatTheEnvironmentOfEveryProgramNames) {
  EXPECT_STREQ(std::setlocale(LC_ALL, nullptr), "C");
  const char* const named = std::getenv("LC_ALL");
  ASSERT_NE(named, nullptr);
  EXPECT_TRUE(std::string(named) == "C" || std::string(named) == "C.UTF-8") << named;
}

}  // namespace
}  // namespace ovws
