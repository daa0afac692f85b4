/// Texts in commands that a person or `ovws setup` gives to a shell.
#pragma once

#include <string>
#include <string_view>

namespace ovws {

/// The text as one word of a POSIX shell: unchanged if no character of it has a meaning there, else
/// in single quotes.
inline std::string shell_word(std::string_view text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!text.empty() && text.find_first_not_of(kPlain) == text.npos) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace ovws
