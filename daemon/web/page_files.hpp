/// The page itself, compiled in: nothing is read from the disk, so no path leads anywhere else.
#pragma once

#include <optional>
#include <string_view>

namespace ovws::web {

struct PageFile {
  std::string_view path;  ///< "/style.css"
  std::string_view type;  ///< media type
  std::string_view text;
};

/// "/" is the page.
std::optional<PageFile> page_file(std::string_view path);

}  // namespace ovws::web
