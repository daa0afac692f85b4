/// Limits on held records and on held pixels: a camera has fewer buffers than there are records.
#include "core/pipeline/record_tap.hpp"

#include <chrono>

namespace ovws {

void RecordTap::offer(Entry& entry, int buffers) OVWS_NONBLOCKING {
  entry.recorded = entry.pixels_recorded = entry.pixels_missed = false;
  if (!open_.load(std::memory_order_acquire)) {
    offered_ = 0;
    return;
  }
  const int every = pixels_every_.load(std::memory_order_relaxed);
  const bool due = every > 0 && offered_++ % std::uint64_t(every) == 0;
  if (held_.load(std::memory_order_acquire) >= max_held_) return;
  const bool room = pixels_held_.load(std::memory_order_acquire) < buffers / 2;
  entry.recorded = true;
  entry.pixels_recorded = due && room;
  entry.pixels_missed = due && !room;
  entry.hold(entry.pixels_recorded);
  held_.fetch_add(1, std::memory_order_relaxed);
  if (entry.pixels_recorded) pixels_held_.fetch_add(1, std::memory_order_relaxed);
}

void RecordTap::put(Entry& entry, bool published) OVWS_NONBLOCKING {
  // The ring has room for every record, so the push cannot fail.
  if (published && ring_.try_push(&entry)) return;
  release(entry);
}

Entry* RecordTap::next(int timeout_us) {
  Entry* entry = nullptr;
  return ring_.pop(entry, std::chrono::microseconds(timeout_us)) ? entry : nullptr;
}

void RecordTap::release(Entry& entry) OVWS_NONBLOCKING {
  if (entry.pixels_recorded) {
    entry.release_pixels();
    pixels_held_.fetch_sub(1, std::memory_order_release);
  }
  entry.release();
  held_.fetch_sub(1, std::memory_order_release);
}

}  // namespace ovws
