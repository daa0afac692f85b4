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
  std::optional<std::string> file;  ///< path of the recording
  double duration_s = 0.0;
  std::uint64_t frames = 0, frames_dropped = 0;
  std::uint64_t pictures = 0, pictures_dropped = 0;
  std::uint64_t documents_dropped = 0;
  std::uint64_t bytes = 0;            ///< size of the file
  std::optional<std::string> reason;  ///< why the recording ended
};
template <>
inline constexpr auto kTable<RecordReport> = Fields{
    "RecordReport",
    field<&RecordReport::state>("off: no recording since the start; recording: one is in progress; "
                                "ended: the values describe the last recording")
        .among(texts<"off", "recording", "ended">),
    field<&RecordReport::file>("path on the daemon's machine; null: no recording yet"),
    field<&RecordReport::duration_s>("duration so far, or of the ended recording, seconds",
                                     Bounds::at_least(0)),
    field<&RecordReport::frames>("number of frames in the file"),
    field<&RecordReport::frames_dropped>(
        "number of published frames that are not in the file because the recorder was too slow"),
    field<&RecordReport::pictures>("number of images in the file"),
    field<&RecordReport::pictures_dropped>(
        "number of frames in the file whose image is missing because the disk was too slow"),
    field<&RecordReport::documents_dropped>(
        "number of documents (plans, steps of a closed loop, settings of the camera) that are not "
        "in the file because the disk was too slow"),
    field<&RecordReport::bytes>("size of the file, bytes"),
    field<&RecordReport::reason>("why the recording ended; null: it has not")};

inline constexpr const char* kPicturesEveryMeaning =
    "record the camera image of every n-th frame; 0: no images";

/// Params of `record.estimate`.
struct RecordEstimate {
  int pictures_every = 1;
};
template <>
inline constexpr auto kTable<RecordEstimate> =
    Fields{"RecordEstimate",
           field<&RecordEstimate::pictures_every>(kPicturesEveryMeaning, limits::kImagesEvery)};

/// Size of a recording before it starts: result of `record.estimate`.
struct RecordSize {
  double bytes_per_frame = 0.0, bytes_per_hour = 0.0;
  std::optional<std::uint64_t> bytes_free;
  std::optional<double> hours_free;
};
template <>
inline constexpr auto kTable<RecordSize> =
    Fields{"RecordSize",
           field<&RecordSize::bytes_per_frame>(
               "mean size of a frame in the file, bytes, if images could not be compressed",
               Bounds::at_least(0)),
           field<&RecordSize::bytes_per_hour>("bytes_per_frame times the camera's frame_rate_hz, "
                                              "for an hour; compressed images need less",
                                              Bounds::at_least(0)),
           field<&RecordSize::bytes_free>(
               "bytes that recordings may take on their disk; null: no folder is configured"),
           field<&RecordSize::hours_free>(
               "hours until the disk is full at that rate; null: not known", Bounds::at_least(0))};

/// Params of `record.start`.
struct RecordStart {
  std::optional<std::string> name;  ///< file name without folder and extension
  int pictures_every = 1;           ///< record the image of every n-th frame; 0: no images
  std::optional<double> limit_s, limit_mib;
};
/// Why `name` is not a plain file name; none if it is plain, or not given.
std::optional<std::string> not_plain(const std::optional<std::string>& name);
template <>
inline constexpr auto kTable<RecordStart> = Fields{
    "RecordStart",
    field<&RecordStart::name>("file name without the extension .h5; the file must not exist yet; "
                              "null: run- and the time, UTC")
        .checked(not_plain),
    field<&RecordStart::pictures_every>(kPicturesEveryMeaning, limits::kImagesEvery),
    field<&RecordStart::limit_s>(
        "duration after which the recording ends by itself, seconds; null: no limit",
        limits::kRecordS),
    field<&RecordStart::limit_mib>(
        "file size at which the recording ends by itself, MiB; null: no limit",
        limits::kRecordMib)};

}  // namespace ovws
