/// Folder of the persistent state: one JSON file with a checksum for each item. Kind and name
/// identify an item.
///
/// A file is JSON text: {"schema": "ovws.state.KIND/1", "content": {…}, "sha256": "…"}. The
/// checksum covers all bytes before its own line. replace_file writes each file atomically: after a
/// kill or a power cut, the file is complete, either old or new.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/config.hpp"
#include "core/base/result.hpp"

namespace ovws {

/// State folder: `config.directory`, or else the first folder of $STATE_DIRECTORY; none if neither
/// is set.
std::optional<std::string> state_directory_of(const StateConfig& config);

struct StateItem {
  std::string name;
  nlohmann::json content;
  std::string sha256;
};

/// Converts content to file text with a checksum (seal), and back to an item without a name
/// (unseal). Errors of unseal (Errc::invalid): the text is cut off, damaged, or of another schema.
/// The caller checks the meaning of the content.
std::string seal(std::string_view schema, const nlohmann::json& content);
Result<StateItem> unseal(std::string_view schema, std::string_view text);

/// Folder lock (flock), held while a copy of the pointer exists, at most until the process ends.
/// Null if locking is impossible: the folder cannot be made or opened, or its file system has no
/// locks.
using FolderLock = std::shared_ptr<const int>;

/// Creates the folder if it is missing, and locks it. Errc::unavailable (field "state.directory")
/// if another process holds the lock.
Result<FolderLock> lock_folder(const std::string& folder);

/// The files in a state directory. Thread-safe, but two threads may not write one item at a time.
/// All calls block on the disk, except path_of and text_of.
class StateFolder {
 public:
  /// Creates the directory if it is missing, and removes leftovers of a killed writer. Errors
  /// (Errc::unavailable, field "state.directory"): the directory cannot be created or read.
  static Result<StateFolder> open(const std::string& directory);

  /// Why the directory cannot be written, and what to do; none if it can. Existing items are still
  /// read.
  const std::optional<std::string>& why_read_only() const { return why_read_only_; }
  int leftovers() const { return leftovers_; }  ///< number of leftover files that `open` removed

  /// Path of an item's file. Kinds and names consist of [a-z0-9_-].
  std::string path_of(std::string_view kind, std::string_view name) const;
  /// Whether there is a file of that name, whatever is in it.
  bool holds(std::string_view kind, std::string_view name) const;
  /// The text of an item's file.
  static std::string text_of(std::string_view kind, const nlohmann::json& content);

  /// Writes a text of text_of atomically and returns its checksum. Errors: see replace_file.
  Result<std::string> write(std::string_view kind, std::string_view name, std::string_view text);
  /// Deletes an item; a missing item is no error. Errors: see remove_file.
  Result<void> remove(std::string_view kind, std::string_view name);
  /// Renames an outdated file whose successor cannot be written, so that it is no longer read. The
  /// next write or removal of this item deletes the renamed file. A missing file is no error.
  Result<void> set_aside(std::string_view kind, std::string_view name);
  /// Creates the directory again if it was removed. Returns true if it was created.
  bool recreate();

  /// Names of the items of a kind, sorted.
  std::vector<std::string> names(std::string_view kind) const;
  /// Reads an item. Errors: its file cannot be read; see unseal.
  Result<StateItem> read(std::string_view kind, std::string_view name) const;

 private:
  explicit StateFolder(std::string directory) : directory_(std::move(directory)) {}

  std::string directory_;
  int leftovers_ = 0;
  std::optional<std::string> why_read_only_;
};

}  // namespace ovws
