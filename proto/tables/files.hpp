/// Field tables of files on the daemon's machine: references by name, and recordings.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/field_json.hpp"
#include "proto/tables/time.hpp"

namespace ovws {

/// Why `name` cannot be the name of a saved reference; none if it can.
inline std::optional<std::string> no_reference_name(const std::string& name) {
  constexpr std::size_t kMaxBytes = 64;
  const auto fits = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (!name.empty() && name.size() <= kMaxBytes && std::all_of(name.begin(), name.end(), fits)) {
    return std::nullopt;
  }
  return "must have 1 to 64 characters: small letters, digits, _ and -";
}

/// Params of `config.save`.
struct ConfigSave {
  bool preview = false;
};
template <>
inline constexpr auto kTable<ConfigSave> =
    Fields{"ConfigSave", field<&ConfigSave::preview>("true: only report what would be saved")};

/// Params of `reference.save`, `reference.load` and `reference.delete`.
struct ReferenceName {
  std::string name;
};
template <>
inline constexpr auto kTable<ReferenceName> = Fields{
    "ReferenceName", field<&ReferenceName::name>("name: 1 to 64 small letters, digits, _ and -")
                         .checked(no_reference_name)
                         .mandatory()};

struct SavedReference {
  std::string name;
  std::int64_t t_taken_ns = 0;
  std::string reason;  ///< why it cannot be loaded now; empty: it can
};
template <>
inline constexpr auto kTable<SavedReference> =
    Fields{"SavedReference",
           field<&SavedReference::name>("name that it was saved under"),
           field<&SavedReference::t_taken_ns>(kTimeMeaning),
           time_text("t_taken", &SavedReference::t_taken_ns),
           computed(
               "usable", [](auto& saved) { return saved.reason.empty(); },
               "whether reference.load would accept it now"),
           field<&SavedReference::reason>("why not; null: it is usable").or_null()};

/// Result of `reference.list`, `reference.save` and `reference.delete`.
struct ReferenceList {
  std::vector<SavedReference> references;
};
template <>
inline constexpr auto kTable<ReferenceList> =
    Fields{"ReferenceList", field<&ReferenceList::references>("the saved references, by name")};

struct RecordingFile {
  std::string name, file;
  std::uint64_t bytes = 0;
  std::int64_t t_modified_ns = 0;
};
template <>
inline constexpr auto kTable<RecordingFile> = Fields{
    "RecordingFile", field<&RecordingFile::name>("name, without the extension .h5"),
    field<&RecordingFile::file>("path on the daemon's machine"),
    field<&RecordingFile::bytes>("size, bytes"),
    field<&RecordingFile::t_modified_ns>("time of the last change, ns since the epoch, UTC")};

/// Result of `record.list`.
struct RecordingList {
  std::optional<std::string> folder;
  std::vector<RecordingFile> recordings;
  int left_off = 0;
};
template <>
inline constexpr auto kTable<RecordingList> =
    Fields{"RecordingList",
           field<&RecordingList::folder>("folder of the recordings; null: none is configured"),
           field<&RecordingList::recordings>("recordings in the folder, the newest first, at most "
                                             "100"),
           field<&RecordingList::left_off>("number of older recordings that are not listed",
                                           Bounds::at_least(0))};

}  // namespace ovws
