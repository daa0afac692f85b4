/// Writes one part.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/result.hpp"
#include "daemon/ovws/parts/part.hpp"

namespace ovws {

/// Writes a temporary file, which `finish` renames: a part is complete, or is not there. Each
/// process has a temporary file of its own.
class PartWriter {
 public:
  /// Errc::unavailable, field "output": the folder cannot be written.
  static Result<PartWriter> make(const std::filesystem::path& folder, const std::string& name,
                                 const PartHead& head);
  PartWriter(PartWriter&&) = default;
  ~PartWriter();

  /// Adds an item, with the JSON text of its result. Call it in the order of the items.
  void add(std::uint64_t item, const std::string& result);
  /// Completes the part: writes NAME.host.json with the facts of this run (host_facts), then
  /// NAME.jsonl. Errc::unavailable, field "output": the disk does not take it.
  Result<void> finish();

  const std::filesystem::path& path() const { return path_; }

 private:
  PartWriter(std::filesystem::path path, std::filesystem::path temporary, std::FILE* file);

  struct Close {
    void operator()(std::FILE* file) const { (void)std::fclose(file); }
  };
  std::filesystem::path path_, temporary_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace ovws
