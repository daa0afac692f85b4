/// Field tables of recordings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "proto/field_json.hpp"

namespace ovws {

/// State of the current or the last recording: result of `record.start`, `record.stop` and
/// `record.get`, and the `record` part of `status`.
struct RecordReport {
  std::string state = "off";        ///< "off", "recording", "ended"
  std::optional<std::string> file;  ///< its path
  double duration_s = 0.0;
  std::uint64_t frames = 0, frames_dropped = 0;
  std::uint64_t pictures = 0, pictures_dropped = 0;
  std::uint64_t bytes = 0;            ///< size of the file
  std::optional<std::string> reason;  ///< why it ended
};
template <>
struct Table<RecordReport> {
  static constexpr const char* kName = "RecordReport";
  static constexpr auto kFields = Fields{
      field("state", &RecordReport::state,
            "off: nothing was recorded since the start; recording; ended: the last one has, and "
            "this is of it")
          .among([] {
            return std::vector<std::string>{"off", "recording", "ended"};
          }),
      field("file", &RecordReport::file, "path on the daemon's machine; null: there was none"),
      field("duration_s", &RecordReport::duration_s,
            "since its begin, or as long as it was, seconds", Bounds::at_least(0)),
      field("frames", &RecordReport::frames, "in the file"),
      field("frames_dropped", &RecordReport::frames_dropped,
            "published meanwhile and not in the file: the recorder was behind"),
      field("pictures", &RecordReport::pictures, "in the file"),
      field("pictures_dropped", &RecordReport::pictures_dropped,
            "frames in the file that lack the picture they were to have: the disk could not "
            "follow"),
      field("bytes", &RecordReport::bytes, "size of the file"),
      field("reason", &RecordReport::reason, "why it ended; null: it has not")};
};

/// Params of `record.start`.
struct RecordStart {
  std::string name;        ///< file name without folder and extension
  int pictures_every = 1;  ///< record the image of every n-th frame; 0: no images
  std::optional<double> limit_s, limit_mib;
};
/// Why `name` is not a plain file name; none if it is one.
std::optional<std::string> not_plain(const std::string& name);
template <>
struct Table<RecordStart> {
  static constexpr const char* kName = "RecordStart";
  static constexpr auto kFields =
      Fields{field("name", &RecordStart::name,
                   "of the file, which gets the ending .h5; no file may have it yet")
                 .must()
                 .checked(not_plain),
             field("pictures_every", &RecordStart::pictures_every,
                   "the camera's image of every n-th frame; 0: none", limits::kPicturesEvery),
             field("limit_s", &RecordStart::limit_s,
                   "the recording ends by itself after so many seconds; null: it does not",
                   limits::kRecordS),
             field("limit_mib", &RecordStart::limit_mib,
                   "it ends when the file has become so many MiB large; null: it does not",
                   limits::kRecordMib)};
};

}  // namespace ovws
