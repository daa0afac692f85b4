/// Fork-join of one frame's slices with an atomic countdown.
#include "core/pipeline/tracker_crew.hpp"

#include <chrono>

namespace ovws {
namespace {

using namespace std::chrono_literals;

/// Every ring has room for all records: a push cannot fail.
void push(SpscRing<Entry*>& ring, Entry* entry) {
  [[maybe_unused]] const bool had_room = ring.try_push(entry);
}

}  // namespace

TrackerCrew::TrackerCrew(const Config& config, const Deps& deps)
    : deps_(deps), inbox_(std::size_t(config.records)) {
  for (int k = 0; k < config.workers; ++k) {
    slices_.push_back(std::make_unique<SpscRing<Entry*>>(std::size_t(config.records)));
  }
}

void TrackerCrew::submit(Entry& entry) OVWS_NONBLOCKING {
  push(inbox_, &entry);
  if (waiting_.fetch_add(1, std::memory_order_acq_rel) == 0) start_next();
}

void TrackerCrew::start_next() OVWS_NONBLOCKING {
  Entry* entry = nullptr;
  if (!inbox_.try_pop(entry)) return;
  deps_.stage.begin(*entry);
  working_.store(int(slices_.size()), std::memory_order_relaxed);
  for (const auto& slice : slices_) push(*slice, entry);
}

bool TrackerCrew::run_worker(int k) {
  Entry* entry = nullptr;
  if (!slices_[k]->pop(entry, 20ms)) return false;
  deps_.stage.track_slice(*entry, k);
  if (working_.fetch_sub(1, std::memory_order_acq_rel) == 1) finish(*entry);
  return true;
}

void TrackerCrew::finish(Entry& entry) OVWS_NONBLOCKING {
  deps_.stage.finish(entry);
  push(deps_.tracked, &entry);
  if (waiting_.fetch_sub(1, std::memory_order_acq_rel) > 1) start_next();
}

}  // namespace ovws
