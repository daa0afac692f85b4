/// Reference-counted records; only the acquisition thread takes and frees them.
#include "core/pipeline/record_pool.hpp"

#include <algorithm>
#include <utility>

#include "core/optics/lattice.hpp"

namespace ovws {

namespace {

void allocate(FrameRecord& record) {
  record.starts.resize(kMaxSubapertures);
  record.spots.resize(kMaxSubapertures);
  record.coefficients.resize(kMaxModes);
  record.sigma_waves.resize(kMaxModes);
}

}  // namespace

RecordPool::RecordPool(int records, int beams)
    : size_(records),
      entries_(new Entry[std::size_t(records)]),
      beam_entries_(new Entry[std::size_t(records) * std::size_t(beams)]) {
  free_.reserve(std::size_t(records));
  for (int i = 0; i < records; ++i) {
    allocate(entries_[i]);
    entries_[i].estimates.resize(kMaxSubapertures);
    for (int k = 0; k < beams; ++k) {
      Entry& beam = beam_entries_[i * beams + k];
      allocate(beam);
      entries_[i].beam_records.push_back(&beam);
    }
    free_.push_back(&entries_[i]);
  }
}

Entry* RecordPool::take(const GrabbedFrame& frame, const MeasurementPlan& plan,
                        bool image_wanted) OVWS_NONBLOCKING {
  if (free_.empty()) return nullptr;
  Entry& entry = *free_.back();
  free_.pop_back();
  entry.frame = frame;
  entry.plan = &plan;
  entry.image_wanted = image_wanted;
  entry.lent_slot_ = frame.slot;
  ++lent_;
  const int holds = image_wanted ? 2 : 1;
  entry.pixel_holds_.store(holds, std::memory_order_relaxed);
  entry.holds_.store(holds, std::memory_order_relaxed);
  entry.plan_id_.store(plan.id, std::memory_order_release);
  return &entry;
}

void RecordPool::reclaim(Camera* camera) OVWS_NONBLOCKING {
  for (int i = 0; i < size_ && int(free_.size()) < size_; ++i) {
    Entry& entry = entries_[i];
    if (entry.plan_id_.load(std::memory_order_relaxed) == Entry::kFree) continue;
    if (camera != nullptr && entry.lent_slot_ >= 0 &&
        entry.pixel_holds_.load(std::memory_order_acquire) <= 0) {
      camera->release(std::exchange(entry.lent_slot_, -1));
      --lent_;
    }
    if (entry.lent_slot_ >= 0 || entry.holds_.load(std::memory_order_acquire) > 0) continue;
    entry.plan_id_.store(Entry::kFree, std::memory_order_release);
    free_.push_back(&entry);
  }
}

std::uint64_t RecordPool::oldest_plan_id() const {
  std::uint64_t oldest = Entry::kFree;
  for (int i = 0; i < size_; ++i) {
    oldest = std::min(oldest, entries_[i].plan_id_.load(std::memory_order_acquire));
  }
  return oldest;
}

}  // namespace ovws
