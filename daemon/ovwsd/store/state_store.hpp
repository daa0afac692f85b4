/// Persistent state: one JSON file with a checksum for each item. Kind and name identify an item.
///
/// A file is JSON text: {"schema": "ovws.state.KIND/1", "content": {…}, "sha256": "…"}. The
/// checksum covers all bytes before its own line, so that no changed byte goes unnoticed.
/// replace_file writes every file: a kill or a power cut leaves the old one or the new one.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

/// Converts content to the text of a file with its checksum, and back. Errors (Errc::invalid): the
/// text is cut off, damaged, or of another schema. The caller checks the meaning of the content.
std::string seal(std::string_view schema, const nlohmann::json& content);
struct Unsealed {
  nlohmann::json content;
  std::string sha256;
};
Result<Unsealed> unseal(std::string_view schema, std::string_view text);

struct StateItem {
  std::string name, path;
  nlohmann::json content;
  std::string sha256;
};

/// A file that cannot be used, and why; it stays where it is.
struct BadState {
  std::string path, reason;
};

/// The lock (flock), held while a copy lives, at most until the process ends. Null where nothing
/// can be locked: the folder cannot be made or opened, or its file system has no locks.
using FolderLock = std::shared_ptr<const int>;

/// Makes the folder if there is none, and locks it. Errc::unavailable (field "state.directory") if
/// another process holds it.
Result<FolderLock> lock_folder(const std::string& folder);

/// The files of a state directory. Thread-safe, but two threads may not write the same item at
/// once. All calls block on the disk.
class StateStore {
 public:
  /// Makes the directory if there is none, and removes leftovers of a killed writer. Errors
  /// (Errc::unavailable, field "state.directory"): it cannot be made or read.
  static Result<StateStore> open(const std::string& directory);

  /// Why nothing can be written there, and what to do; none: it can. Existing items are read all
  /// the same.
  const std::optional<std::string>& why_read_only() const { return why_read_only_; }
  int leftovers() const { return leftovers_; }  ///< that `open` removed

  /// The text of an item's file.
  static std::string text_of(std::string_view kind, const nlohmann::json& content);
  /// Kinds and names are of [a-z0-9_-]. Replaces the item of that name atomically and returns its
  /// checksum. Errors: see replace_file.
  Result<std::string> put(std::string_view kind, std::string_view name,
                          const nlohmann::json& content);
  /// The same with a text that `text_of` made.
  Result<std::string> put_text(std::string_view kind, std::string_view name, std::string_view text);
  /// Deletes an item; it is no error if there is none. Errors: see remove_file.
  Result<void> drop(std::string_view kind, std::string_view name);
  /// Renames the item's file, so that it is not loaded any more: it is outdated, and its successor
  /// cannot be written. The next put or drop of that name removes it. It is no error if there is
  /// none.
  Result<void> set_aside(std::string_view kind, std::string_view name);
  /// Makes the directory again if it was removed; true: it was.
  bool recreate_directory();

  /// The item of that name; none if there is none, or its file is damaged.
  std::optional<StateItem> find(std::string_view kind, std::string_view name) const;
  /// The item that a file with this text would hold.
  StateItem item_of(std::string_view kind, std::string_view name, std::string_view text) const;

  /// Hands over the items of a kind, by name and one at a time, for they may be large. Returns the
  /// damaged files.
  std::vector<BadState> load(std::string_view kind,
                             const std::function<void(StateItem)>& take) const;

 private:
  explicit StateStore(std::string directory) : directory_(std::move(directory)) {}
  std::string path_of(std::string_view kind, std::string_view name) const;
  Result<StateItem> read(std::string_view kind, std::string name) const;

  std::string directory_;
  int leftovers_ = 0;
  std::optional<std::string> why_read_only_;
};

}  // namespace ovws
