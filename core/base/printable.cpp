#include "core/base/printable.hpp"

#include <algorithm>

namespace ovws {
namespace {

/// Decoded UTF-8 character: length in bytes and code point. Length 0 means invalid UTF-8.
struct Character {
  std::size_t bytes = 0;
  char32_t code = 0;
};

Character first_of(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return {1, first};
  const std::size_t bytes = (first >> 5) == 0x6    ? 2
                            : (first >> 4) == 0xe  ? 3
                            : (first >> 3) == 0x1e ? 4
                                                   : 0;
  if (bytes == 0 || bytes > text.size()) return {};
  char32_t code = first & (0x7fU >> bytes);
  for (std::size_t k = 1; k < bytes; ++k) {
    if ((byte(k) & 0xc0U) != 0x80U) return {};
    code = (code << 6) | (byte(k) & 0x3fU);
  }
  constexpr char32_t kMinCode[]{0, 0, 0x80, 0x800, 0x10000};  // by bytes; less is overlong
  const bool surrogate = code >= 0xd800 && code < 0xe000;
  return code < kMinCode[bytes] || code > 0x10ffff || surrogate ? Character{}
                                                                : Character{bytes, code};
}

bool is_plain(char32_t code) {
  const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
  const bool layout = (code >= 0x200b && code < 0x2010) || (code >= 0x2028 && code < 0x202f) ||
                      (code >= 0x2060 && code < 0x2070) || code == 0xfeff;
  return !control && !layout;
}

}  // namespace

std::string printable(std::string_view text, std::size_t max_bytes) {
  constexpr std::string_view kEllipsis = "...";
  std::string out;
  std::size_t fits = 0;  // bytes of `out` that leave room for kEllipsis
  while (!text.empty()) {
    const Character next = first_of(text);
    const bool plain = next.bytes > 0 && is_plain(next.code);
    const std::size_t bytes = std::max<std::size_t>(next.bytes, 1);
    if (out.size() + (plain ? bytes : 1) > max_bytes) return out.substr(0, fits).append(kEllipsis);
    out.append(plain ? text.substr(0, bytes) : "?");
    text.remove_prefix(bytes);
    if (out.size() + kEllipsis.size() <= max_bytes) fits = out.size();
  }
  return out;
}

}  // namespace ovws
