/// Frames on their way from the pipeline to the file: copies in memory that is taken once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/pipeline/frame_record.hpp"
#include "core/rt/spsc_ring.hpp"
#include "daemon/ovwsd/record/picture_memory.hpp"
#include "proto/recording.hpp"

namespace ovws {

struct TakenFrame {
  RecordedFrame row;  ///< but for where its parts are in the file
  std::uint64_t number = 0;
  std::vector<RecordedSpot> spots;
  std::vector<float> coefficients;
  std::span<std::byte> pixels;  ///< without padding; empty: no picture
};

/// One taking thread and one writing thread.
class FrameStore {
 public:
  /// Room for `pictures` pictures of so many bytes, and for four thousand frames without.
  FrameStore(std::size_t pictures, std::size_t picture_bytes);

  /// Taking thread, frames in the order of their numbers. A frame that finds no room is left out,
  /// or its picture is.
  void take(const FrameRecord& record, bool with_picture);

  // Writing thread.
  TakenFrame* next(int timeout_us);  ///< nullptr: none came
  void give_back(TakenFrame* frame);
  /// How many frames came after the one of that number, taken or left out; 0: of all.
  std::uint64_t taken_after(std::uint64_t number) const;
  /// Whether pictures come faster than they are written.
  bool behind() const { return free_pictures_.size_approx() < pictures_ / 2; }

 private:
  void copy_picture(const ImageView& image, TakenFrame& to);

  std::vector<TakenFrame> frames_;
  const std::size_t pictures_, picture_bytes_;
  PictureMemory memory_;
  SpscRing<TakenFrame*> free_frames_, full_;
  SpscRing<std::byte*> free_pictures_;
  std::atomic<std::uint64_t> first_number_{0}, last_number_{0};  ///< 0: none came yet
};

}  // namespace ovws
