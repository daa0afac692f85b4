/// Publishes records: frame gaps, drops and reference counts.
#include "core/pipeline/outbox.hpp"

#include <chrono>

#include "core/port/clock.hpp"

namespace ovws {

Outbox::Outbox(int records, Counters& counters, RecordTap& tap)
    : max_published_(records - records / 4),
      counters_(counters),
      tap_(tap),
      published_(std::size_t(records)),
      images_(std::size_t(records)) {}

void Outbox::put(Entry& entry) OVWS_NONBLOCKING {
  const bool publish = held_by_publisher_.load(std::memory_order_acquire) < max_published_;
  if (publish) {
    link(entry);
    count(entry);
    held_by_publisher_.fetch_add(1, std::memory_order_relaxed);
  }
  // Neither push can fail, because the rings have room for every record. This stage's own hold
  // keeps `entry` alive even if the image thread has already released its hold.
  if (entry.image_wanted && !images_.try_push(&entry)) release_image(entry);
  const bool recorded = entry.recorded;  // read now: the entry may be reused after its release
  if (!publish) {
    counters_.add(Counter::frames_dropped);
    entry.release();
  } else if (!published_.try_push(&entry)) {
    release(entry);
  }
  if (recorded) tap_.put(entry, publish);
}

void Outbox::link(Entry& entry) OVWS_NONBLOCKING {
  entry.number = ++published_count_;
  const std::uint64_t id = entry.frame.frame_id;
  const bool goes_on = entry.stream == last_stream_ && id > last_frame_id_;
  entry.gap = goes_on ? id - last_frame_id_ - 1 : gap_between_streams(entry);
  last_arrival_mono_ns_ = entry.frame.t_arrival_mono_ns;
  last_stream_ = entry.stream;
  last_frame_id_ = id;
  for (FrameRecord* const beam : entry.beams()) {
    beam->number = entry.number;
    beam->gap = entry.gap;
  }
}

/// Estimates the frame gap after the frame numbers restarted, from elapsed time and frame period.
std::uint64_t Outbox::gap_between_streams(const Entry& entry) const {
  if (last_arrival_mono_ns_ == 0 || entry.period_ns <= 0) return 0;
  const double periods =
      double(entry.frame.t_arrival_mono_ns - last_arrival_mono_ns_) / double(entry.period_ns);
  return periods > 1.5 ? std::uint64_t(periods - 0.5) : 0;
}

void Outbox::count(const Entry& entry) OVWS_NONBLOCKING {
  counters_.add(Counter::frames_published);
  if (!entry.valid) counters_.add(Counter::frames_invalid);
  if (!entry.explained) counters_.add(Counter::frames_unexplained);
  const std::int64_t taken_ns = monotonic_ns() - entry.frame.t_arrival_mono_ns;
  if (entry.period_ns > 0 && taken_ns > entry.period_ns) {
    counters_.add(Counter::deadline_missed);
  }
}

Entry* Outbox::next(int timeout_us) {
  Entry* entry = nullptr;
  return published_.pop(entry, std::chrono::microseconds(timeout_us)) ? entry : nullptr;
}

void Outbox::release(Entry& entry) OVWS_NONBLOCKING {
  entry.release();
  held_by_publisher_.fetch_sub(1, std::memory_order_release);
}

Entry* Outbox::next_image(int timeout_us) {
  Entry* entry = nullptr;
  return images_.pop(entry, std::chrono::microseconds(timeout_us)) ? entry : nullptr;
}

void Outbox::release_image(Entry& entry) OVWS_NONBLOCKING {
  entry.release_pixels();
  entry.release();
}

}  // namespace ovws
