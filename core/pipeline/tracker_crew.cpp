/// Fork-join of one frame's slices with an atomic countdown.
#include "core/pipeline/tracker_crew.hpp"

#include <chrono>

namespace ovws {
namespace {

using namespace std::chrono_literals;

/// Pushes an entry. This cannot fail, because every ring has room for all records.
void push(SpscRing<Entry*>& ring, Entry* entry) {
  [[maybe_unused]] const bool had_room = ring.try_push(entry);
}

}  // namespace

TrackerCrew::TrackerCrew(int workers, int records, TrackStages& stage, SpscRing<Entry*>& tracked)
    : stage_(stage), tracked_(tracked), inbox_(std::size_t(records)) {
  for (int k = 0; k < workers; ++k) {
    slices_.push_back(std::make_unique<SpscRing<Entry*>>(std::size_t(records)));
  }
}

void TrackerCrew::submit(Entry& entry) OVWS_NONBLOCKING {
  push(inbox_, &entry);
  if (waiting_.fetch_add(1, std::memory_order_acq_rel) == 0) start_next();
}

void TrackerCrew::start_next() OVWS_NONBLOCKING {
  Entry* entry = nullptr;
  if (!inbox_.try_pop(entry)) return;
  stage_.begin(*entry);
  working_.store(int(slices_.size()), std::memory_order_relaxed);
  for (const auto& slice : slices_) push(*slice, entry);
}

bool TrackerCrew::run_worker(int k) {
  Entry* entry = nullptr;
  if (!slices_[k]->pop(entry, 20ms)) return false;
  stage_.track_slice(*entry, k);
  if (working_.fetch_sub(1, std::memory_order_acq_rel) == 1) finish(*entry);
  return true;
}

void TrackerCrew::finish(Entry& entry) OVWS_NONBLOCKING {
  stage_.finish(entry);
  push(tracked_, &entry);
  if (waiting_.fetch_sub(1, std::memory_order_acq_rel) > 1) start_next();
}

}  // namespace ovws
