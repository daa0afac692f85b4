#include "daemon/examine/machine/machine.hpp"

#include <array>
#include <charconv>
#include <fstream>
#include <utility>

namespace ovws::examine {

std::optional<std::string> text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  std::array<char, 4096> part;
  while (file.read(part.data(), part.size()) || file.gcount() > 0) {
    text.append(part.data(), std::size_t(file.gcount()));
  }
  return file.eof() ? std::optional(std::move(text)) : std::nullopt;
}

std::optional<std::string> word_of(const std::string& path) {
  std::ifstream file(path);
  std::string word;
  if (!(file >> word)) return std::nullopt;
  return word;
}

std::optional<std::int64_t> number_of(const std::string& path) {
  const auto word = word_of(path);
  std::int64_t number = 0;
  if (!word) return std::nullopt;
  const auto read = std::from_chars(word->data(), word->data() + word->size(), number);
  if (read.ec != std::errc{} || read.ptr != word->data() + word->size()) return std::nullopt;
  return number;
}

}  // namespace ovws::examine
