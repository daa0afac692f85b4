/// Output queue for recording: every record, and the pixels of some.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/realtime.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/rt/spsc_ring.hpp"

namespace ovws {

/// Recording queue that never blocks the pipeline. A slow recorder loses records, which shows as
/// gaps in `number`. Holds at most a quarter of all records.
class RecordTap {
 public:
  explicit RecordTap(int records)
      : max_held_(records / 4), ring_(static_cast<std::size_t>(records)) {}

  // Any thread.
  /// Starts recording with the next frame: all records, and the pixels of every n-th frame; 0:
  /// none.
  void open(int pixels_every) {
    pixels_every_.store(pixels_every, std::memory_order_relaxed);
    open_.store(true, std::memory_order_release);
  }
  void close() { open_.store(false, std::memory_order_release); }

  /// Acquisition thread, before any other thread has seen the entry: adds the recorder's holds.
  /// Holds the pixels of at most half of the camera's `buffers`.
  void offer(Entry& entry, int buffers) OVWS_NONBLOCKING;
  /// Thread of the last stage: queues a recorded entry, or releases it if it was not published.
  void put(Entry& entry, bool published) OVWS_NONBLOCKING;

  // Recording thread.
  Entry* next(int timeout_us);
  void release(Entry& entry) OVWS_NONBLOCKING;

 private:
  const int max_held_;
  std::atomic<bool> open_{false};
  std::atomic<int> pixels_every_{1};
  std::atomic<int> held_{0};
  std::atomic<int> pixels_held_{0};
  std::uint64_t offered_ = 0;  ///< only the acquisition thread uses it
  SpscRing<Entry*> ring_;
};

}  // namespace ovws
