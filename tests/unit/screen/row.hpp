/// The characters of a canvas as text.
#pragma once

#include <string>

#include "daemon/ovws/screen/canvas.hpp"

namespace ovws::screen {

inline void append_utf8(std::string& out, char32_t glyph) {
  if (glyph < 0x80) {
    out += char(glyph);
  } else if (glyph < 0x800) {
    out += char(0xc0 | (glyph >> 6));
    out += char(0x80 | (glyph & 0x3f));
  } else {
    out += char(0xe0 | (glyph >> 12));
    out += char(0x80 | ((glyph >> 6) & 0x3f));
    out += char(0x80 | (glyph & 0x3f));
  }
}

/// One row as UTF-8.
inline std::string row(const Canvas& canvas, int y) {
  std::string out;
  for (int x = 0; x < canvas.width(); ++x) append_utf8(out, canvas.at(x, y).glyph);
  return out;
}

}  // namespace ovws::screen
