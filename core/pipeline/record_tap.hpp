/// The second way out, beside the publisher's: every record for who keeps them, with the pixels of
/// some.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/realtime.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/rt/spsc_ring.hpp"

namespace ovws {

/// Whoever takes the records may be behind: then records pass by, and nothing waits. Their numbers
/// tell how many.
class RecordTap {
 public:
  explicit RecordTap(int records)
      : most_held_(records / 4), ring_(static_cast<std::size_t>(records)) {}

  // Any thread.
  /// From the next frame on: the records, and the pixels of every n-th of them; 0: of none.
  void open(int pixels_every) {
    pixels_every_.store(pixels_every, std::memory_order_relaxed);
    open_.store(true, std::memory_order_release);
  }
  void close() { open_.store(false, std::memory_order_release); }

  /// Acquisition thread, of an entry that no other has seen. At most half of the camera's
  /// `buffers` are kept.
  void offer(Entry& entry, int buffers) OVWS_NONBLOCKING;
  /// Thread of the last stage, of a recorded entry that was published, or not.
  void put(Entry& entry, bool published) OVWS_NONBLOCKING;

  // The taker's thread.
  Entry* next(int timeout_us);
  void release(Entry& entry) OVWS_NONBLOCKING;

 private:
  const int most_held_;
  std::atomic<bool> open_{false};
  std::atomic<int> pixels_every_{1};
  std::atomic<int> held_{0};
  std::atomic<int> pixels_held_{0};
  std::uint64_t offered_ = 0;  ///< acquisition thread
  SpscRing<Entry*> ring_;
};

}  // namespace ovws
