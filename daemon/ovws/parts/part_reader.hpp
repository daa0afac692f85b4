/// Reads the parts of one whole, and checks that they are all of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "daemon/ovws/parts/part.hpp"

namespace ovws {

/// Parts that belong together. Keeps one line of each in memory.
class PartReader {
 public:
  /// Opens the parts, in any order. Errors, which name the files: Errc::invalid, field "parts" (not
  /// a part; of another command, version, option or recording; a share is missing or there twice),
  /// Errc::unavailable (a file cannot be read).
  static Result<PartReader> open(const std::vector<std::string>& paths);

  const PartHead& head() const { return heads_.front(); }
  const std::vector<std::string>& paths() const { return paths_; }

  /// The next item of the whole; none after the last. Errc::invalid, field "parts": an item is
  /// missing, is there twice, or cannot be read.
  Result<std::optional<PartItem>> next();

 private:
  PartReader() = default;
  Result<void> open_part(const std::string& path);
  Result<void> read(std::size_t part);

  struct Waiting {
    std::size_t part;
    PartItem line;
  };
  std::vector<std::string> paths_;
  std::vector<PartHead> heads_;
  std::vector<std::unique_ptr<std::ifstream>> files_;
  std::map<std::uint64_t, Waiting> waiting_;  ///< next line of each part, by its item
  std::uint64_t next_item_ = 0;
};

}  // namespace ovws
