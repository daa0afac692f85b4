/// What the daemon found out and keeps over a restart: items of a kind and a name, one file each.
///
/// A file is JSON text: {"schema": "ovws.state.KIND/1", "content": {…}, "sha256": "…"}. The
/// checksum is that of all bytes before its own line, so that no byte of a file can change unseen.
/// Every file is written by replace_file: a kill or a power cut leaves the old one or the new one.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.hpp"

namespace ovws {

/// The text of a file, and back. Errors (Errc::invalid): it is cut off, damaged, or of another
/// schema. What is read has passed its checksum; what it means is for its owner to check.
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

/// A file that cannot be used, and why; it is left where it is.
struct BadState {
  std::string path, reason;
};

/// Thread-safe, but two threads may not write the same item at once. Everything waits for the disk.
class StateStore {
 public:
  /// Makes the directory if there is none, and removes what a killed writer left in it. Errors
  /// (Errc::unavailable, field "state.directory"): it cannot be made, or cannot be read.
  static Result<StateStore> open(const std::string& directory);

  const std::string& directory() const { return directory_; }
  /// Why nothing can be written there, and what to do; none: it can. What is there is read all the
  /// same.
  const std::optional<std::string>& why_read_only() const { return why_read_only_; }
  int leftovers() const { return leftovers_; }  ///< that `open` removed

  /// The text of an item's file.
  static std::string text_of(std::string_view kind, const nlohmann::json& content);
  /// Kinds and names are of [a-z0-9_-]. Replaces the item of that name, whole or not at all;
  /// returns its checksum. Errors as of replace_file.
  Result<std::string> put(std::string_view kind, std::string_view name,
                          const nlohmann::json& content);
  /// The same of a text that `text_of` made.
  Result<std::string> put_text(std::string_view kind, std::string_view name, std::string_view text);
  /// It is no error if there is none. Errors as of remove_file.
  Result<void> drop(std::string_view kind, std::string_view name);
  /// Renames the item's file, so that it is not loaded any more: it is outdated, and the one that
  /// should replace it cannot be written. The next put or drop of that name removes it. It is no
  /// error if there is none.
  Result<void> set_aside(std::string_view kind, std::string_view name);
  /// Makes the directory again if it was removed; true: it did.
  bool make_again();

  /// The one item of that name; none if there is none, or it is not whole.
  std::optional<StateItem> find(std::string_view kind, std::string_view name) const;
  /// The item of such a text.
  StateItem item_of(std::string_view kind, std::string_view name, std::string_view text) const;

  /// Hands over each whole item, by name and one at a time, for they may be large; returns the
  /// files that are not whole.
  std::vector<BadState> load(std::string_view kind,
                             const std::function<void(StateItem)>& take) const;

 private:
  explicit StateStore(std::string directory) : directory_(std::move(directory)) {}
  std::string path_of(std::string_view kind, std::string_view name) const;

  std::string directory_;
  int leftovers_ = 0;
  std::optional<std::string> why_read_only_;
};

}  // namespace ovws
