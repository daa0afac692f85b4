/// What may reach a terminal, and where.
#include "daemon/ovws/screen/canvas.hpp"

#include <gtest/gtest.h>

#include "tests/unit/screen/row.hpp"

namespace ovws::screen {
namespace {

std::string drawn(std::string_view words, bool unicode = true) {
  Canvas canvas(12, 1, unicode);
  const int used = canvas.text(0, 0, 10, words);
  EXPECT_LE(used, 10);
  EXPECT_EQ(canvas.at(11, 0), Cell{}) << "beyond its width";
  std::string text = row(canvas, 0);
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

TEST(Canvas, CutsTextAndSaysSo) {
  EXPECT_EQ(drawn("1234567890"), "1234567890");
  EXPECT_EQ(drawn("12345678901"), "123456789…");
  EXPECT_EQ(drawn("µµµµµµµµµµ"), "µµµµµµµµµµ");
}

TEST(Canvas, LetsNothingThroughThatMovesTheCursor) {
  EXPECT_EQ(drawn("a\033[2Jb\n\r\tc"), "a?[2Jb???c");
  EXPECT_EQ(drawn("\x7f\xc2\x9b"), "??");  // delete, and the C1 control sequence introducer
  EXPECT_EQ(drawn("漢e\xcc\x81"), "?e?");  // two columns wide; a combining accent
  // Right to left, and of no width.
  EXPECT_EQ(drawn("\xe2\x80\xae"
                  "x"
                  "\xe2\x80\x8b"
                  "y"),
            "?x?y");
  EXPECT_EQ(drawn("😀"), "?");
}

TEST(Canvas, ReadsWhatIsNoUtf8) {
  EXPECT_EQ(drawn("\xff\xfe"), "??");
  EXPECT_EQ(drawn("\xc3"), "?");
  EXPECT_EQ(drawn("\xe2\x82"), "??");
  EXPECT_EQ(drawn("\xc3("), "?(");
}

TEST(Canvas, HasAsciiForWhoeverHasNoMore) {
  EXPECT_EQ(drawn("█▌│●✕→↙…µé", false), "##|ox>/~u?");
}

TEST(Canvas, LeavesOutWhatIsOutsideOfThePage) {
  Canvas canvas(3, 2, true);
  for (const int x : {-1, 3}) canvas.put(x, 0, U'x');
  for (const int y : {-1, 2}) canvas.put(0, y, U'x');
  canvas.fill({-5, -5, 6, 6}, {U'f', Style::normal});
  canvas.text(2, 1, 10, "text");
  EXPECT_EQ(row(canvas, 0), "f  ");
  EXPECT_EQ(row(canvas, 1), "  t");
  EXPECT_EQ(Canvas(-1, 5, true).width(), 0);
}

}  // namespace
}  // namespace ovws::screen
