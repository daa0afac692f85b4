#include "daemon/ovws/text/wrap.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

namespace ovws::cli {
namespace {

std::size_t width_of(const std::string& text) {
  return std::size_t(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string wrapped_line(const std::string& line, std::size_t columns, std::size_t indent) {
  if (columns == 0 || width_of(line) <= columns) return line;
  std::string done, row, word;
  for (std::size_t k = 0; k <= line.size(); ++k) {
    if (k < line.size() && line[k] != ' ') {
      word += line[k];
      continue;
    }
    const bool begun = row.find_first_not_of(' ') != std::string::npos;
    if (begun && !word.empty() && width_of(row) + width_of(word) > columns) {
      done += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
      row.assign(indent, ' ');
    }
    row += word + " ";
    word.clear();
  }
  return done + row.substr(0, row.find_last_not_of(' ') + 1);
}

}  // namespace

std::string wrapped(const std::string& text, std::size_t columns, std::size_t indent) {
  std::string all;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    all += (all.empty() ? "" : "\n") + wrapped_line(line, columns, indent);
  }
  return all;
}

std::size_t terminal_columns() {
  constexpr std::size_t kUsual = 80;
  if (isatty(STDOUT_FILENO) == 0) return 0;
  winsize size{};
  const bool is_known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return is_known ? size.ws_col : kUsual;
}

}  // namespace ovws::cli
