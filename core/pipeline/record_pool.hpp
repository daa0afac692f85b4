/// Pool of reference-counted frame records and the camera buffers that they hold.
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

/// A frame record with the pipeline's internal data.
struct Entry : FrameRecord {
  Measurement* measurement = nullptr;
  std::uint64_t stream = 0;  ///< number of the camera stream; frame numbers do not continue from
                             ///< stream to stream
  std::vector<SpotEstimates> estimates;  ///< template estimates of each spot, if plan->fit is set
  bool image_wanted = false;
  bool recorded = false;         ///< RecordTap holds this record
  bool pixels_recorded = false;  ///< RecordTap holds the pixels, too

  /// Adds a hold on the record, and on its pixels if `pixels`. Acquisition thread, before any other
  /// thread has seen the entry.
  void hold(bool pixels) OVWS_NONBLOCKING {
    holds_.fetch_add(1, std::memory_order_relaxed);
    if (pixels) pixel_holds_.fetch_add(1, std::memory_order_relaxed);
  }
  /// Release a hold, from any thread. The acquisition thread returns the buffer, or frees the
  /// entry, on its next iteration after the last hold on it was released.
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

/// A further source's measurement in `entry`. The downcast is safe: every record of the pool is an
/// Entry.
inline Entry& beam_of(Entry& entry, std::size_t k) {
  return static_cast<Entry&>(*entry.beam_records[k]);
}

/// Pool of frame records. All methods are for the acquisition thread, unless stated otherwise.
class RecordPool {
 public:
  /// `beams`: number of further light sources whose measurements a record can hold.
  explicit RecordPool(int records, int beams = 0);

  /// Takes a free record that holds `frame`'s buffer; nullptr: no record is free. `image_wanted`
  /// adds a hold of the record and of its pixels for the image thread.
  Entry* take(const GrabbedFrame& frame, const MeasurementPlan& plan,
              bool image_wanted) OVWS_NONBLOCKING;

  /// Returns buffers without holds to the camera, and frees records without holds. Without a camera
  /// (nullptr), a record with a lent buffer stays in use.
  void reclaim(Camera* camera) OVWS_NONBLOCKING;

  /// Number of buffers not yet returned to the camera.
  int lent() const { return lent_; }

  /// Smallest plan id among the records in use; UINT64_MAX if none is in use. Any thread.
  std::uint64_t oldest_plan_id() const;

 private:
  int size_;
  std::unique_ptr<Entry[]> entries_;
  std::unique_ptr<Entry[]> beam_entries_;  ///< of FrameRecord::beam_records
  std::vector<Entry*> free_;
  int lent_ = 0;
};

}  // namespace ovws
