#include "daemon/ovws/screen/canvas.hpp"

#include <algorithm>

namespace ovws::screen {
namespace {

/// The nearest ASCII character.
char32_t ascii(char32_t glyph) {
  constexpr std::u32string_view kGlyphs = U"█▌▐│─●✕→←↑↓↗↙↖↘…µ", kAscii = U"###|-ox><^v//\\\\~u";
  static_assert(kGlyphs.size() == kAscii.size());
  if (glyph < 0x80) return glyph;
  const std::size_t at = kGlyphs.find(glyph);
  return at == kGlyphs.npos ? U'?' : kAscii[at];
}

/// Whether the character takes one column on every terminal: Latin, Greek, Cyrillic, punctuation,
/// arrows, box drawing.
bool takes_one_column(char32_t glyph) {
  const bool letters = (glyph >= 0x20 && glyph < 0x7f) || (glyph >= 0xa1 && glyph < 0x300) ||
                       (glyph >= 0x370 && glyph < 0x483) || (glyph >= 0x48a && glyph < 0x530);
  const bool signs = (glyph >= 0x2010 && glyph < 0x2028) || (glyph >= 0x2190 && glyph < 0x2300) ||
                     (glyph >= 0x2500 && glyph < 0x25fd) || glyph == U'✕';
  constexpr char32_t kSoftHyphen = 0xad;
  return (letters || signs) && glyph != kSoftHyphen;
}

/// Decodes and removes the first UTF-8 character; returns "?" for invalid UTF-8.
char32_t take_character(std::string_view& utf8) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(utf8[k]); };
  const unsigned char first = byte(0);
  const std::size_t length = first < 0x80           ? 1
                             : (first >> 5) == 0x6  ? 2
                             : (first >> 4) == 0xe  ? 3
                             : (first >> 3) == 0x1e ? 4
                                                    : 0;
  if (length == 0 || length > utf8.size()) {
    utf8.remove_prefix(1);
    return U'?';
  }
  char32_t glyph = length == 1 ? first : first & (0x7fU >> length);
  for (std::size_t k = 1; k < length; ++k) {
    if ((byte(k) & 0xc0) != 0x80) {
      utf8.remove_prefix(1);
      return U'?';
    }
    glyph = (glyph << 6) | (byte(k) & 0x3fU);
  }
  utf8.remove_prefix(length);
  return takes_one_column(glyph) ? glyph : U'?';
}

}  // namespace

Canvas::Canvas(int width, int height, bool unicode)
    : width_(std::max(width, 0)),
      height_(std::max(height, 0)),
      unicode_(unicode),
      cells_(std::size_t(width_) * std::size_t(height_)) {}

void Canvas::put(int x, int y, char32_t glyph, Style style) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  cells_[std::size_t(y * width_ + x)] = {unicode_ ? glyph : ascii(glyph), style};
}

int Canvas::text(int x, int y, int width, std::string_view utf8, Style style) {
  int used = 0;
  while (!utf8.empty() && used < width) {
    const char32_t glyph = take_character(utf8);
    ++used;
    put(x + used - 1, y, used == width && !utf8.empty() ? U'…' : glyph, style);
  }
  return used;
}

void Canvas::fill(Rect rect, Cell cell) {
  for (int y = rect.y; y < rect.y + rect.height; ++y) {
    for (int x = rect.x; x < rect.x + rect.width; ++x) put(x, y, cell.glyph, cell.style);
  }
}

}  // namespace ovws::screen
