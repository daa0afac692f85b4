/// Output queues of the pipeline: finished records for the publisher and for the image thread.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/realtime.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/pipeline/record_tap.hpp"
#include "core/rt/counters.hpp"
#include "core/rt/spsc_ring.hpp"

namespace ovws {

class Outbox {
 public:
  /// The publisher may hold at most three quarters of all records. The last quarter lets tracking
  /// continue while the publisher is slow.
  Outbox(int records, Counters& counters, RecordTap& tap);

  /// Thread of the last stage: queues the record, or drops and counts it (frames_dropped). The
  /// caller must not use the record afterwards.
  void put(Entry& entry) OVWS_NONBLOCKING;

  Entry* next(int timeout_us);                  ///< publisher thread
  void release(Entry& entry) OVWS_NONBLOCKING;  ///< publisher thread

  Entry* next_image(int timeout_us);                  ///< image thread
  void release_image(Entry& entry) OVWS_NONBLOCKING;  ///< image thread

 private:
  void link(Entry& entry) OVWS_NONBLOCKING;
  std::uint64_t gap_between_streams(const Entry& entry) const;
  void count(const Entry& entry) OVWS_NONBLOCKING;

  const int max_published_;
  Counters& counters_;
  RecordTap& tap_;
  SpscRing<Entry*> published_;
  SpscRing<Entry*> images_;
  std::atomic<int> held_by_publisher_{0};
  std::uint64_t published_count_ = 0;      ///< only the last stage's thread uses it
  std::uint64_t last_stream_ = 0;          ///< only the last stage's thread uses it
  std::uint64_t last_frame_id_ = 0;        ///< only the last stage's thread uses it
  std::int64_t last_arrival_mono_ns_ = 0;  ///< last stage's thread; 0: none yet
};

}  // namespace ovws
