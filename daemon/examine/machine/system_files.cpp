#include "daemon/examine/machine/machine.hpp"

#include <array>
#include <fstream>
#include <utility>

#include "core/base/number_text.hpp"

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
  return word ? number_from<std::int64_t>(*word) : std::nullopt;
}

}  // namespace ovws::examine
