#include "daemon/ovws/text/wrap.hpp"

#include <gtest/gtest.h>

namespace ovws::cli {
namespace {

TEST(Wrap, LinesBreakAtSpacesAndContinueIndented) {
  EXPECT_EQ(wrapped("one two three", 8, 2), "one two\n  three");
  EXPECT_EQ(wrapped("  key   a value here", 14, 8), "  key   a\n        value\n        here");
  EXPECT_EQ(wrapped("first\nsecond line", 7, 0), "first\nsecond\nline");
}

TEST(Wrap, WhatFitsOrCannotBreakStays) {
  EXPECT_EQ(wrapped("any length", 0, 2), "any length");
  EXPECT_EQ(wrapped("one  two", 8, 2), "one  two");
  EXPECT_EQ(wrapped("unbreakable", 4, 2), "unbreakable");
  EXPECT_EQ(wrapped("µµµ µµµ", 7, 2), "µµµ µµµ");
}

}  // namespace
}  // namespace ovws::cli
