/// The records, and who still holds which of them, and which camera buffers they keep lent.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/pipeline/frame_record.hpp"
#include "core/port/camera.hpp"

namespace ovws {

struct Measurement;

/// A record with what only the pipeline needs to know of it.
struct Entry : FrameRecord {
  Measurement* measurement = nullptr;
  std::uint64_t stream = 0;    ///< counts attached cameras: frame numbers of one do not go on in
                               ///< the next
  std::int64_t period_ns = 0;  ///< frame period at the time of the frame; 0: not known
  bool image_wanted = false;
  bool recorded = false;         ///< RecordTap holds it
  bool pixels_recorded = false;  ///< and its pixels

  /// Acquisition thread, before any other has seen the entry.
  void hold(bool pixels) OVWS_NONBLOCKING {
    holds_.fetch_add(1, std::memory_order_relaxed);
    if (pixels) pixel_holds_.fetch_add(1, std::memory_order_relaxed);
  }
  /// Let go of from any thread, seen by the acquisition thread on its next turn.
  void release_pixels() OVWS_NONBLOCKING { pixel_holds_.fetch_sub(1, std::memory_order_release); }
  void release() OVWS_NONBLOCKING { holds_.fetch_sub(1, std::memory_order_release); }

 private:
  friend class RecordPool;
  std::atomic<int> pixel_holds_{0};
  std::atomic<int> holds_{0};
  static constexpr std::uint64_t kFree = std::numeric_limits<std::uint64_t>::max();
  std::atomic<std::uint64_t> plan_id_{kFree};
  int lent_slot_ = -1;  ///< acquisition thread only
};

/// Acquisition thread, unless said.
class RecordPool {
 public:
  explicit RecordPool(int records);

  /// A free record that holds `frame`'s buffer, or nullptr. `image_wanted` adds a hold of record
  /// and pixels for the image thread to those of the stages.
  Entry* take(const GrabbedFrame& frame, const MeasurementPlan& plan,
              bool image_wanted) OVWS_NONBLOCKING;

  /// Gives buffers that nobody holds any more back to the camera, and makes records free.
  void reclaim(Camera& camera) OVWS_NONBLOCKING;
  /// Makes records free; no buffer may be lent.
  void reclaim() OVWS_NONBLOCKING;

  /// Buffers that the camera still has to get back.
  int lent() const { return lent_; }

  /// Smallest id of the plans that records in use refer to; UINT64_MAX if none is. Any thread.
  std::uint64_t oldest_plan_id() const;

 private:
  void free_if_unheld(Entry& entry) OVWS_NONBLOCKING;

  int size_;
  std::unique_ptr<Entry[]> entries_;
  std::vector<Entry*> free_;
  int lent_ = 0;
};

}  // namespace ovws
