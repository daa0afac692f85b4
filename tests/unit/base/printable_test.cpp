/// Text from devices is sanitised: no control characters or invalid UTF-8 reach logs and terminals.
#include "core/base/printable.hpp"

#include <gtest/gtest.h>

namespace ovws {
namespace {

TEST(Printable, KeepsPlainTextOfAnyScript) {
  for (const char* text : {"", "Baumer VCXG-32M (700006)", "0.3 µm, Ω, 光, 🙂"}) {
    EXPECT_EQ(printable(text, 100), text);
  }
}

TEST(Printable, ReplacesWhatATerminalOrAJournalObeys) {
  EXPECT_EQ(printable("a\x1b[2Jb\r\n<0>c\x7f\td", 100),
            "a?[2Jb?"
            "?<0>c?"
            "?d");
  EXPECT_EQ(printable(std::string("a\0b", 3), 100), "a?b");
  EXPECT_EQ(printable("a\u009bb\u202eb\u2028c\u200bd\ufeff", 100), "a?b?b?c?d?");
}

TEST(Printable, ReplacesBytesThatAreNoUtf8OneByOne) {
  EXPECT_EQ(printable("a\xff\xc3", 100), "a??");
  EXPECT_EQ(printable("\xe2\x82", 100), "??");
  EXPECT_EQ(printable("\xc0\xaf", 100), "??");            // overlong
  EXPECT_EQ(printable("\xed\xa0\x80", 100), "???");       // surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80", 100), "????");  // beyond Unicode
}

TEST(Printable, CutsBetweenCharactersAndSaysSo) {
  EXPECT_EQ(printable("abcdef", 6), "abcdef");
  EXPECT_EQ(printable("abcdefg", 6), "abc...");
  EXPECT_EQ(printable("abµµµ", 7), "abµ...");
  EXPECT_EQ(printable(std::string(100'000, '\x1b'), 64).size(), 64U);
}

}  // namespace
}  // namespace ovws
