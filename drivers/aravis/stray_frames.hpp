/// Frames that Aravis throws away unseen, because it has delivered their number or a later one.
#pragma once

#include <algorithm>
#include <cstdint>

namespace ovws {

/// Aravis delivers no GigE frame that comes again or after a later one; it only counts the packets.
/// As many as a frame has are such a frame: one that was missing, if the stream has just left
/// numbers out (with Aravis's own bound, less than 100 ago), and one delivered before otherwise. So
/// a frame that comes again shortly after another was lost is taken for that. RT-safe.
class StrayFrames {
 public:
  struct Counts {
    int duplicate = 0;
    int out_of_order = 0;
  };

  explicit StrayFrames(std::uint64_t packets_per_frame) : packets_per_frame_(packets_per_frame) {}

  /// A frame was delivered; an incomplete one has no number.
  void delivered(std::uint64_t frame_id) {
    const std::uint64_t left_out = any_ && frame_id > last_ ? frame_id - last_ - 1 : 0;
    if (left_out > incomplete_) {
      missing_ = std::min(missing_ + left_out - incomplete_, kLatest);
      newest_gap_ = frame_id;
    }
    if (frame_id > newest_gap_ + kLatest) missing_ = 0;
    any_ = true;
    last_ = std::max(last_, frame_id);
    incomplete_ = 0;
  }
  void delivered_incomplete() { ++incomplete_; }

  /// With all packets thrown away since the stream began: what is new since the last call.
  Counts thrown_away(std::uint64_t packets) {
    const std::uint64_t fresh = packets > packets_ ? packets - packets_ : 0;
    packets_ = std::max(packets_, packets);
    // Single packets, of resent parts for example, never add up to a frame.
    rest_ = fresh > 0 ? rest_ + fresh : 0;
    Counts counts;
    for (; rest_ >= packets_per_frame_; rest_ -= packets_per_frame_) {
      ++(missing_ > 0 ? counts.out_of_order : counts.duplicate);
      if (missing_ > 0) --missing_;
    }
    return counts;
  }

 private:
  static constexpr std::uint64_t kLatest = 99;

  std::uint64_t packets_per_frame_;
  std::uint64_t packets_ = 0;
  std::uint64_t rest_ = 0;
  std::uint64_t missing_ = 0;
  std::uint64_t newest_gap_ = 0;
  std::uint64_t last_ = 0;
  std::uint64_t incomplete_ = 0;
  bool any_ = false;
};

}  // namespace ovws
