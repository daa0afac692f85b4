/// A part: some items of a study or of a replay, computed on one machine, in a file of JSON lines.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

/// First line of a part. Parts belong together if all but `share` is the same. Nothing in a part
/// depends on the machine that computed it.
struct PartHead {
  std::string part_of;      ///< command: "study NAME" or "replay"
  std::string version;      ///< of the program
  nlohmann::json options;   ///< everything else that the items depend on
  std::uint64_t items = 0;  ///< of all parts together
  std::string share;        ///< "i/N": the items i-1, i-1+N, …; "A:B": the items A to B-1
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PartHead, part_of, version, options, items, share)

/// Each further line. A part has its items in rising order.
struct PartItem {
  std::uint64_t item = 0;
  nlohmann::json result;
};

/// Creates a folder for output, unless it is there, and checks that it is writable.
/// Errc::unavailable, field "output".
Result<void> make_folder(const std::filesystem::path& folder);

/// Adds an item to a part, with the JSON text of its result. Call it in the order of the items.
using AddItem = std::function<void(std::uint64_t item, const std::string& result)>;

/// Writes the part NAME.jsonl, whose items `fill` adds, and before it NAME.host.json with the facts
/// of this run (host_facts). Returns the part's path. A part is complete, or is not there: it has a
/// temporary name, of this process, until then. Errors: those of `fill`; Errc::unavailable, field
/// "output": the folder cannot be written, or the disk does not take the part.
Result<std::filesystem::path> write_part(const std::filesystem::path& folder,
                                         const std::string& name, const PartHead& head,
                                         const std::function<Result<void>(const AddItem&)>& fill);

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
