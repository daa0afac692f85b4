/// Text wrapped for a terminal.
#pragma once

#include <cstddef>
#include <string>

namespace ovws::cli {

/// Breaks each line at spaces so that it has at most `columns` columns; 0: no limit. Continued
/// lines begin with `indent` spaces. Words longer than a line stay whole. Counts UTF-8 characters.
std::string wrapped(const std::string& text, std::size_t columns, std::size_t indent);

/// Columns of the terminal at standard output; 0: it is not a terminal.
std::size_t terminal_columns();

}  // namespace ovws::cli
