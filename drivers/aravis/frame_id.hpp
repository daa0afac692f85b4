/// Frame number unwrapping to 64 bits: GigE Vision cameras count 1 … 65535 and restart at 1.
#pragma once

#include <algorithm>
#include <cstdint>

namespace ovws {

/// Unwraps the camera's frame numbers. Consecutive frames differ by exactly 1; the frames before
/// and after k lost frames differ by k + 1. The first number is unchanged. A duplicate frame, or a
/// frame less than 100 frames late, keeps its own number.
class FrameIdUnwrapper {
 public:
  enum class Width { bits16, bits64 };  ///< bits16: GigE Vision, where 0 is never sent

  explicit FrameIdUnwrapper(Width width) : width_(width) {}

  /// Unwraps the number of the next frame. A number 100 or more behind the last number, or with 16
  /// bits more than half the range ahead, means that the camera reset its counter. The result is
  /// then the last result plus 1, because the number of lost frames is unknown. RT-safe.
  std::uint64_t next(std::uint64_t raw) {
    if (any_ && same_stream_)
      if (const std::uint64_t behind = steps_behind(raw);
          behind < kLateLimit && behind <= unwrapped_)
        return unwrapped_ - behind;
    if (!any_)
      unwrapped_ = raw;
    else
      unwrapped_ += same_stream_ ? std::max<std::uint64_t>(steps_from_last(raw), 1) : 1;
    any_ = same_stream_ = true;
    last_ = raw;
    return unwrapped_;
  }

  /// Begins a new stream, whose raw numbers are arbitrary: the next frame gets the last unwrapped
  /// number plus 1.
  void restart() { same_stream_ = false; }

 private:
  static constexpr std::uint64_t kMaxId16 = 65535;
  static constexpr std::uint64_t kLateLimit = 100;

  /// Distance of `raw` behind the last number (0: equal); kLateLimit or more: not a late frame.
  std::uint64_t steps_behind(std::uint64_t raw) const {
    if (width_ == Width::bits64) return raw <= last_ ? last_ - raw : kLateLimit;
    return (last_ + kMaxId16 - raw % kMaxId16) % kMaxId16;
  }

  /// Distance of `raw` ahead of the last number; 0: not ahead.
  std::uint64_t steps_from_last(std::uint64_t raw) const {
    if (width_ == Width::bits64) return raw > last_ ? raw - last_ : 0;
    const std::uint64_t step = (raw + kMaxId16 - last_ % kMaxId16) % kMaxId16;
    return step <= kMaxId16 / 2 ? step : 0;
  }

  Width width_;
  bool any_ = false;
  bool same_stream_ = false;
  std::uint64_t last_ = 0;
  std::uint64_t unwrapped_ = 0;
};

}  // namespace ovws
