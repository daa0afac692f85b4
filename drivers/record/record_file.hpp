/// Writer of a recording. If the process is killed at any moment, the file holds everything up to
/// the last flush.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "proto/recording.hpp"

namespace ovws {

/// Usual number of spots and modes of a frame, for which the file is laid out. Frames may have
/// more. `beams`: number of further light sources; a file for 0 takes no spots of them.
struct RecordedWidth {
  std::size_t spots = 19, modes = 18, beams = 0;
};

/// What the recording lacks because the disk was too slow.
struct RecordedLosses {
  std::uint64_t frames = 0, pictures = 0, documents = 0;
};

/// Recording file; only one thread at a time may use it. Unless stated otherwise, errors are
/// Errc::unavailable with the field "path", and the reason names the remedy. After a failed write
/// the file holds everything up to the last flush, and every later write fails.
class RecordFile {
 public:
  /// Errors: the file exists already, or cannot be created; no new file is left behind.
  static Result<std::unique_ptr<RecordFile>> create(const std::string& path,
                                                    const RecordingHeader& header,
                                                    RecordedWidth expected = {});

  /// Writes an image without padding and returns its row in `pictures`. With `compress` false the
  /// image is stored uncompressed, which saves CPU time.
  Result<std::int64_t> add_image(std::span<const std::byte> pixels, bool compress);
  /// Adds a frame, buffered until the next flush. Fills in its first_spot, spots, first_coefficient
  /// and coefficients. `sigma_waves`: standard errors, as many as `coefficients`. `beam_spots`:
  /// spots of the further light sources, one source after the other.
  void add_frame(RecordedFrame frame, std::span<const RecordedSpot> spots,
                 std::span<const float> coefficients, std::span<const float> sigma_waves,
                 std::span<const RecordedSpot> beam_spots = {});
  /// Names the columns of `coefficients`: OSA/ANSI index of each coefficient of the next frames. A
  /// column that had another mode before is called 0.
  void name_modes(std::span<const int> modes_j);
  /// Adds a document that applies from the next added frame on. `kind` has at most 15 bytes.
  /// Errc::refused if more documents or text would exceed the limits of RecordingReader.
  Result<void> add_document(std::string_view kind, std::string_view sha256, std::string_view text);

  // Number of rows added so far; after a failed write, the number that is certainly in the file.
  std::uint64_t frames() const;
  std::uint64_t pictures() const;
  std::uint64_t bytes() const;  ///< current size of the file
  /// Whether the file is still at its path: false if it was removed or replaced by another file.
  bool in_place() const;

  /// Hands everything added so far to the kernel, where it survives a kill of this process.
  Result<void> flush(const RecordedLosses& dropped);
  /// Flushes, marks the recording as ended and closes the file. Nothing may be added afterwards.
  Result<void> close(const RecordedLosses& dropped);

 private:
  struct Impl;
  explicit RecordFile(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

}  // namespace ovws
