/// Reader of recordings; every part is validated before it is used.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/hidden.hpp"
#include "core/base/result.hpp"
#include "proto/recording.hpp"

namespace ovws {

struct RecordedText {
  std::string kind, sha256;
  std::string text;
};

/// Recording reader; only one thread at a time may use it. It also reads a recording that is still
/// being written or was cut off, in the state at `open`.
class RecordingReader {
 public:
  /// Errors, field "path": Errc::unavailable (cannot be opened), Errc::invalid (not a recording, or
  /// damaged); the reason names the part.
  static Result<std::unique_ptr<RecordingReader>> open(const std::string& path);

  const RecordingHeader& header() const;
  /// All frames. Every spot, coefficient and image row that a frame refers to exists.
  const std::vector<RecordedFrame>& frames() const;
  std::size_t image_bytes() const;
  /// Documents that are missing because the disk was too slow.
  std::uint64_t documents_dropped() const;

  Result<std::vector<RecordedSpot>> spots(const RecordedFrame& frame);
  /// The first `count` spots of the further light sources. Errc::invalid: the file has fewer.
  Result<std::vector<RecordedSpot>> beam_spots(const RecordedFrame& frame, std::size_t count);
  Result<std::vector<float>> coefficients(const RecordedFrame& frame);
  /// Standard errors of the coefficients, waves.
  Result<std::vector<float>> sigma_waves(const RecordedFrame& frame);
  /// OSA/ANSI indices of the columns of the coefficients; 0: it changed, or no frame has it.
  Result<std::vector<int>> columns_j();
  /// Reads the image of a frame that has one: image_bytes() into `out`.
  Result<void> picture(const RecordedFrame& frame, std::span<std::byte> out);
  /// The JSON documents of the recording (plans, and what they refer to: proto/RECORDING.md) in
  /// file order. The caller must compare each text with its checksum.
  Result<std::vector<RecordedText>> documents();

 private:
  struct Impl;
  explicit RecordingReader(Hidden<Impl> impl) : impl_(std::move(impl)) {}
  Hidden<Impl> impl_;
};

}  // namespace ovws
