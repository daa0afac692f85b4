/// Recordings that a browser may download: the daemon's list, one-time tickets, and the files.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.hpp"
#include "daemon/shared/client.hpp"

namespace ovws::web {

/// Path of a download, followed by the recording's name and, optionally, "&ticket=" and a ticket.
constexpr std::string_view kRecordingPath = "/recording?name=";

struct DownloadQuery {
  std::string name;    ///< a plain name, without folder and extension
  std::string ticket;  ///< empty: none
};
/// Parses what follows kRecordingPath. None if the name is not plain.
std::optional<DownloadQuery> parse_download(std::string_view query);

/// Tickets for downloads. A browser saves a file to disk only if it fetches the file by itself, and
/// then it sends no token; a ticket in the address stands for it. Each is for one download of one
/// recording. Used by one thread.
class Tickets {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kLifetime{30};
  static constexpr std::size_t kMost = 16;  ///< a further ticket replaces the oldest one

  std::string give(const std::string& name, Clock::time_point now = Clock::now());
  /// Whether the ticket is valid for this recording. A ticket for another one, or that is too old,
  /// is used up.
  bool check(const DownloadQuery& query, Clock::time_point now = Clock::now());
  /// Uses up a valid ticket, when its download begins.
  void take(const DownloadQuery& query);

 private:
  struct Given {
    std::string ticket, name;
    Clock::time_point end;
  };
  std::deque<Given>::iterator find(const std::string& ticket);

  std::deque<Given> given_;  ///< oldest first
};

/// An open file, closed by the destructor.
class OpenRecording {
 public:
  OpenRecording(int descriptor, std::uint64_t bytes) : descriptor_(descriptor), bytes_(bytes) {}
  ~OpenRecording();
  OpenRecording(OpenRecording&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)), bytes_(other.bytes_) {}
  OpenRecording(const OpenRecording&) = delete;
  OpenRecording& operator=(const OpenRecording&) = delete;
  OpenRecording& operator=(OpenRecording&&) = delete;

  std::uint64_t bytes() const { return bytes_; }  ///< size when it was opened
  /// At most `most` bytes from `offset`; fewer at the end of the file; empty at an error. Blocks.
  std::string read(std::uint64_t offset, std::size_t most) const;

 private:
  int descriptor_;
  std::uint64_t bytes_;
};

/// Result of record.list with "unreadable": why this program cannot read the folder, and what to
/// do, or null. Blocks.
tl::expected<nlohmann::json, cli::CallFailure> list_recordings(const cli::Common& common);

/// Opens a recording that record.list names: a regular file in its folder, not a link. Blocks.
/// Errors (field "name"): Errc::invalid if the list does not have it, Errc::refused if it cannot be
/// read, Errc::unavailable if the daemon does not answer.
Result<OpenRecording> open_recording(const cli::Common& common, const std::string& name);

/// As above, in this folder.
Result<OpenRecording> open_in_folder(const std::string& folder, const std::string& name);

}  // namespace ovws::web
