/// The page's files, compiled in. Nothing is read from disk, so path traversal is impossible.
#pragma once

#include <optional>
#include <string_view>

namespace ovws::web {

struct PageFile {
  std::string_view path;  ///< "/style.css"
  std::string_view type;  ///< media type
  std::string_view text;
};

/// The file at this path; "/" is index.html. None: no such file.
std::optional<PageFile> page_file(std::string_view path);

}  // namespace ovws::web
