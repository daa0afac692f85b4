/// A recording while it is written. A kill at any moment leaves a file that holds all up to the
/// last flush.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.hpp"
#include "proto/recording.hpp"

namespace ovws {

/// One thread at a time. Every error is Errc::unavailable, field "path", and says what to do: the
/// file then holds all up to the last flush, nothing more can be added, and each later call fails.
class RecordFile {
 public:
  /// Errors: the file is there already, or cannot be made; then there is none.
  static Result<std::unique_ptr<RecordFile>> create(const std::string& path,
                                                    const RecordingHeader& header);
  ~RecordFile();
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  /// A picture without padding: its number. `compress` false: as it is, which takes no time.
  Result<std::int64_t> add_picture(std::span<const std::byte> pixels, bool compress);
  /// Kept until the flush; first_spot and first_coefficient are filled in here.
  void add_frame(RecordedFrame frame, std::span<const RecordedSpot> spots,
                 std::span<const float> coefficients);
  /// In force from the frame that is added next. At most 15 bytes of `kind`. Errc::refused: the
  /// file holds as many as a reader takes.
  Result<void> add_document(std::string_view kind, std::string_view sha256, std::string_view text);

  // What was added; after a write that failed, what is sure to be in the file.
  std::uint64_t frames() const;
  std::uint64_t pictures() const;
  std::uint64_t bytes() const;  ///< of the file now
  /// False: another file has its name, or none.
  bool in_place() const;

  /// Everything added so far is the kernel's from now on.
  Result<void> flush(std::uint64_t frames_dropped, std::uint64_t pictures_dropped);
  /// Flushes and says that the recording has ended. Nothing may be added after.
  Result<void> close(std::uint64_t frames_dropped, std::uint64_t pictures_dropped);

 private:
  struct Impl;
  explicit RecordFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ovws
