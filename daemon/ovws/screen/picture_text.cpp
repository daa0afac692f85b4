#include "daemon/ovws/screen/picture_text.hpp"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "core/base/median.hpp"

namespace ovws::screen {
namespace {

constexpr std::string_view kRamp = " .:-=+*#%@";
constexpr int kFirstGrey = 232, kGreys = 24;  // of the 256 colours

/// The pixel of cell (x, y) that differs most from `median`.
std::uint8_t extreme(const Image<std::uint8_t>& image, int x, int y, int columns, int rows,
                     int median) {
  const int left = x * image.width / columns, top = y * image.height / rows;
  const int right = std::max(left + 1, (x + 1) * image.width / columns);
  const int bottom = std::max(top + 1, (y + 1) * image.height / rows);
  std::uint8_t found = image.at(left, top);
  for (int v = top; v < std::min(bottom, image.height); ++v) {
    for (int u = left; u < std::min(right, image.width); ++u) {
      const std::uint8_t pixel = image.at(u, v);
      if (std::abs(pixel - median) > std::abs(found - median)) found = pixel;
    }
  }
  return found;
}

std::string grey_code(std::uint8_t value) {
  return std::to_string(kFirstGrey + value * (kGreys - 1) / 255);
}

}  // namespace

std::string picture_text(const Image<std::uint8_t>& image, int columns, Shades shades) {
  if (image.pixels.empty() || columns < 1) return {};
  const int median = ovws::median(image.pixels);
  const int lines = std::max(1, columns * image.height / image.width / 2);
  const int rows = shades == Shades::blocks ? 2 * lines : lines;
  const auto at = [&](int x, int y) { return extreme(image, x, y, columns, rows, median); };
  std::string text;
  for (int line = 0; line < lines; ++line) {
    for (int x = 0; x < columns; ++x) {
      if (shades == Shades::ascii) {
        text += kRamp[at(x, line) * (kRamp.size() - 1) / 255];
        continue;
      }
      text += "\x1b[38;5;" + grey_code(at(x, 2 * line)) + ";48;5;" +
              grey_code(at(x, 2 * line + 1)) + "m▀";
    }
    text += shades == Shades::blocks ? "\x1b[0m\n" : "\n";
  }
  return text;
}

}  // namespace ovws::screen
