/// Detection of duplicate and late frames. Aravis discards a frame if it has already delivered this
/// frame number or a later one.
#pragma once

#include <algorithm>
#include <cstdint>

namespace ovws {

/// Counter of duplicate and late GigE frames. Aravis does not deliver them; it only counts their
/// packets as ignored. As many ignored packets as a frame has count as one frame: late if the
/// stream skipped a frame number within the last 100 frames (Aravis's own bound), else duplicate.
/// So a duplicate soon after a lost frame counts as late. RT-safe.
class StrayFrames {
 public:
  struct Counts {
    int duplicate = 0;
    int out_of_order = 0;
  };

  explicit StrayFrames(std::uint64_t packets_per_frame) : packets_per_frame_(packets_per_frame) {}

  /// Records a delivered frame. For an incomplete frame, call delivered_incomplete.
  void delivered(std::uint64_t frame_id) {
    const std::uint64_t skipped = any_ && frame_id > last_ ? frame_id - last_ - 1 : 0;
    if (skipped > incomplete_) {
      missing_ = std::min(missing_ + skipped - incomplete_, kMaxLate);
      newest_gap_ = frame_id;
    }
    if (frame_id > newest_gap_ + kMaxLate) missing_ = 0;
    any_ = true;
    last_ = std::max(last_, frame_id);
    incomplete_ = 0;
  }
  void delivered_incomplete() { ++incomplete_; }

  /// Counts the frames that Aravis discarded since the last call. `packets`: number of packets
  /// ignored since the stream began.
  Counts discarded(std::uint64_t packets) {
    const std::uint64_t added = packets > packets_ ? packets - packets_ : 0;
    packets_ = std::max(packets_, packets);
    // Reset the count when no packets are added, so that single ignored packets (such as resent
    // ones) never add up to a frame.
    rest_ = added > 0 ? rest_ + added : 0;
    Counts counts;
    for (; rest_ >= packets_per_frame_; rest_ -= packets_per_frame_) {
      ++(missing_ > 0 ? counts.out_of_order : counts.duplicate);
      if (missing_ > 0) --missing_;
    }
    return counts;
  }

 private:
  static constexpr std::uint64_t kMaxLate = 99;

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
