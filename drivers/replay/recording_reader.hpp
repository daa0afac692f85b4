/// A recording, read: every part is checked before it is used.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.hpp"
#include "proto/recording.hpp"

namespace ovws {

struct RecordedText {
  std::string kind, sha256;
  std::string text;
};

/// One thread at a time. Also of a recording that goes on or was cut off: then what stood in it
/// when it was opened.
class RecordingReader {
 public:
  /// Errors: Errc::unavailable (it cannot be opened), Errc::invalid (it is no recording, or not
  /// whole), field "path"; the reason names the part.
  static Result<std::unique_ptr<RecordingReader>> open(const std::string& path);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  const RecordingHeader& header() const;
  /// What they refer to is there.
  const std::vector<RecordedFrame>& frames() const;
  std::size_t picture_bytes() const;

  Result<std::vector<RecordedSpot>> spots(const RecordedFrame& frame);
  Result<std::vector<float>> coefficients(const RecordedFrame& frame);
  /// Of a frame that has one: picture_bytes() into `out`.
  Result<void> picture(const RecordedFrame& frame, std::span<std::byte> out);
  /// In their order. Their checksums are the reader's to check.
  Result<std::vector<RecordedText>> documents();

 private:
  struct Impl;
  explicit RecordingReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
