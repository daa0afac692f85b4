/// Frame buffer of a recording: holds copies of frames until they are written to the file, in
/// memory that is allocated once.
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
  std::vector<RecordedSpot> beam_spots;  ///< of the further light sources, in their order
  std::vector<float> coefficients, sigma_waves;
  std::span<std::byte> pixels;  ///< without padding; empty: no image
};

/// SPSC ring buffers of full and free frames, between the thread that takes frames and the thread
/// that writes them.
class FrameStore {
 public:
  static constexpr std::size_t kMaxFrames = 4096;  ///< limit of frames, not of images

  /// Allocates room for `pictures` images of `image_bytes` each, and for kMaxFrames frames.
  /// Throws std::bad_alloc.
  FrameStore(std::size_t pictures, std::size_t image_bytes);

  /// Copies a frame into the buffer; called by the taking thread, in the order of frame numbers. If
  /// the buffer is full, the frame or only its image is dropped.
  void take(const FrameRecord& record, bool with_image);

  // Writing thread.
  TakenFrame* next(int timeout_us);  ///< nullptr: no frame within the timeout
  void give_back(TakenFrame* frame);
  /// Number of frames, taken or dropped, after frame `number`. If `number` is 0, counts all frames.
  std::uint64_t taken_after(std::uint64_t number) const;
  /// True if less than half of the image buffers are free: the disk is too slow for the images.
  bool behind() const { return free_images_.size_approx() < pictures_ / 2; }

 private:
  void copy_image(const ImageView& image, TakenFrame& to);

  std::vector<TakenFrame> frames_;
  const std::size_t pictures_, image_bytes_;
  std::vector<std::unique_ptr<std::byte[]>> memory_;  ///< one block for each image
  SpscRing<TakenFrame*> free_frames_, full_;
  SpscRing<std::byte*> free_images_;
  std::atomic<std::uint64_t> first_number_{0}, last_number_{0};  ///< 0: no frame yet
};

}  // namespace ovws
