/// Camera frame numbers, made endless: GigE Vision counts 1 … 65535 and begins again at 1.
#pragma once

#include <algorithm>
#include <cstdint>

namespace ovws {

/// Turns the camera's numbers into 64-bit ones: those of consecutive frames differ by exactly 1,
/// those across k lost frames by k + 1. The first number is the camera's own. A frame that comes
/// again, or less than 100 frames too late, has the number that is its own.
class FrameIdUnwrapper {
 public:
  enum class Width { bits16, bits64 };  ///< bits16: GigE Vision, where 0 is never sent

  explicit FrameIdUnwrapper(Width width) : width_(width) {}

  /// A number further behind the last one, or for 16 bits half a turn ahead, is a counter that was
  /// set back; what was lost then is unknown and counted as nothing. RT-safe.
  std::uint64_t next(std::uint64_t raw) {
    if (any_ && same_stream_)
      if (const std::uint64_t behind = steps_behind(raw); behind < kLatest && behind <= unwrapped_)
        return unwrapped_ - behind;
    if (!any_)
      unwrapped_ = raw;
    else
      unwrapped_ += same_stream_ ? std::max<std::uint64_t>(steps_from_last(raw), 1) : 1;
    any_ = same_stream_ = true;
    last_ = raw;
    return unwrapped_;
  }

  /// The camera begins a new stream, and may number as it likes: the next frame follows the last.
  void restart() { same_stream_ = false; }

 private:
  static constexpr std::uint64_t kTurn = 65535;
  static constexpr std::uint64_t kLatest = 100;

  /// How far behind the last number, which is 0 behind itself; kLatest or more: not behind it.
  std::uint64_t steps_behind(std::uint64_t raw) const {
    if (width_ == Width::bits64) return raw <= last_ ? last_ - raw : kLatest;
    return (last_ + kTurn - raw % kTurn) % kTurn;
  }

  /// How far ahead of the last number; 0: not ahead of it.
  std::uint64_t steps_from_last(std::uint64_t raw) const {
    if (width_ == Width::bits64) return raw > last_ ? raw - last_ : 0;
    const std::uint64_t step = (raw + kTurn - last_ % kTurn) % kTurn;
    return step <= kTurn / 2 ? step : 0;
  }

  Width width_;
  bool any_ = false;
  bool same_stream_ = false;
  std::uint64_t last_ = 0;
  std::uint64_t unwrapped_ = 0;
};

}  // namespace ovws
