/// The frame buffer of a recording: copies of frames between pipeline and file, in memory allocated
/// once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/pipeline/frame_record.hpp"
#include "core/rt/spsc_ring.hpp"
#include "proto/recording.hpp"

namespace ovws {

struct TakenFrame {
  RecordedFrame row;  ///< without the positions of its parts in the file
  std::uint64_t number = 0;
  std::vector<RecordedSpot> spots;
  std::vector<float> coefficients;
  std::span<std::byte> pixels;  ///< without padding; empty: no image
};

/// A pair of SPSC ring buffers, for full and for free frames: one thread takes frames, one writes
/// them.
class FrameStore {
 public:
  static constexpr std::size_t kMaxFrames = 4096;  ///< without their images

  /// Allocates room for `pictures` images of `image_bytes` each, and for kMaxFrames frames.
  /// Throws std::bad_alloc.
  FrameStore(std::size_t pictures, std::size_t image_bytes);

  /// Taking thread, frames in the order of their numbers: copies a frame. Without room for it the
  /// frame is dropped, or only its image.
  void take(const FrameRecord& record, bool with_image);

  // Writing thread.
  TakenFrame* next(int timeout_us);  ///< nullptr: none came
  void give_back(TakenFrame* frame);
  /// Number of frames that came after the one of that number, taken or dropped; 0: all.
  std::uint64_t taken_after(std::uint64_t number) const;
  /// Whether images come faster than they are written: less than half of their room is free.
  bool behind() const { return free_images_.size_approx() < pictures_ / 2; }

 private:
  void copy_image(const ImageView& image, TakenFrame& to);

  std::vector<TakenFrame> frames_;
  const std::size_t pictures_, image_bytes_;
  std::vector<std::unique_ptr<std::byte[]>> memory_;  ///< of each image
  SpscRing<TakenFrame*> free_frames_, full_;
  SpscRing<std::byte*> free_images_;
  std::atomic<std::uint64_t> first_number_{0}, last_number_{0};  ///< 0: none came yet
};

}  // namespace ovws
