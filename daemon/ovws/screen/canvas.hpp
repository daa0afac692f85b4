/// Off-screen buffer of character cells.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ovws::screen {

/// Text style: the meaning of a character, which the terminal maps to colour and weight.
enum class Style { normal, dim, strong, title, positive, negative, alarm };

struct Cell {
  char32_t glyph = U' ';
  Style style = Style::normal;
  friend bool operator==(const Cell&, const Cell&) = default;
};

/// Rectangle in characters; the origin is the upper left corner.
struct Rect {
  int x = 0, y = 0, width = 0, height = 0;
};

class Canvas {
 public:
  /// `width` and `height` in cells. `unicode` false: characters outside ASCII become the nearest
  /// ASCII character, or "?".
  Canvas(int width, int height, bool unicode);

  int width() const { return width_; }
  int height() const { return height_; }
  const Cell& at(int x, int y) const { return cells_[std::size_t(y * width_ + x)]; }
  Rect all() const { return {0, 0, width_, height_}; }

  /// Sets one cell; ignores positions outside the canvas.
  void put(int x, int y, char32_t glyph, Style style = Style::normal);
  /// Writes UTF-8 text, at most `width` characters; the last one is "…" if the text is longer.
  /// Characters that could move a terminal's cursor (control, wide and combining ones) and invalid
  /// UTF-8 become "?". Returns the number of characters written.
  int text(int x, int y, int width, std::string_view utf8, Style style = Style::normal);
  void fill(Rect rect, Cell cell);

 private:
  int width_, height_;
  bool unicode_;
  std::vector<Cell> cells_;
};

}  // namespace ovws::screen
