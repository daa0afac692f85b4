/// A page of characters, drawn before a terminal sees it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ovws::screen {

/// What a character means; the terminal makes colours and weights of it.
enum class Style { normal, dim, strong, title, positive, negative, alarm };

struct Cell {
  char32_t glyph = U' ';
  Style style = Style::normal;
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// Part of a page, in characters from its left upper corner.
struct Rect {
  int x = 0, y = 0, width = 0, height = 0;
};

class Canvas {
 public:
  /// `unicode` false: what is not ASCII is drawn as its nearest ASCII sign, or as "?".
  Canvas(int width, int height, bool unicode);

  int width() const { return width_; }
  int height() const { return height_; }
  const Cell& at(int x, int y) const { return cells_[std::size_t(y * width_ + x)]; }
  Rect all() const { return {0, 0, width_, height_}; }

  /// What is outside of the page is left out.
  void put(int x, int y, char32_t glyph, Style style = Style::normal);
  /// UTF-8, at most `width` characters, the last one "…" if that is not all. What could move a
  /// terminal's cursor (control characters, wide and combining ones) or is no UTF-8 becomes "?".
  /// Returns how many characters it took.
  int text(int x, int y, int width, std::string_view utf8, Style style = Style::normal);
  void fill(Rect rect, Cell cell);
  /// One row as UTF-8.
  std::string row(int y) const;

 private:
  int width_, height_;
  bool unicode_;
  std::vector<Cell> cells_;
};

}  // namespace ovws::screen
