/// Continuity first, neighbours for single losses, the whole image when continuity is gone.
#include "core/pipeline/track_stage.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/optics/lattice.hpp"
#include "core/pipeline/measurement.hpp"
#include "core/port/clock.hpp"

namespace ovws {
namespace {

std::span<SpotFix> spots_of(Entry& entry) {
  return {entry.spots.data(), std::size_t(entry.spot_count)};
}

int count_found(std::span<const SpotFix> spots) {
  return int(std::count_if(spots.begin(), spots.end(), [](const SpotFix& s) { return s.found(); }));
}

/// Fewer spots than these of a search without history are as likely chance as spots.
int credible(int subapertures) {
  return std::max(3, subapertures / 4);
}

}  // namespace

TrackStage::TrackStage(const Config& config, const Deps& deps)
    : config_(config),
      deps_(deps),
      starts_px_(kMaxSubapertures),
      doubled_(kMaxSubapertures),
      searched_(kMaxSubapertures) {}

void TrackStage::begin(Entry& entry) OVWS_NONBLOCKING {
  entry.spot_count = entry.plan->subapertures();
  history_.fit_to(*entry.plan);
  history_.starts(entry, starts_px_);
}

void TrackStage::track_slice(Entry& entry, int k) OVWS_NONBLOCKING {
  const int begin = entry.spot_count * k / config_.slices;
  const int end = entry.spot_count * (k + 1) / config_.slices;
  const SpotTracker& tracker = *entry.plan->tracker;
  TrackScratch& scratch = entry.measurement->track_scratch[k];
  for (int i = begin; i < end; ++i) {
    const bool known = !std::isnan(starts_px_[i].x);
    entry.spots[i] = known ? tracker.track(entry.frame.image, starts_px_[i], scratch) : SpotFix{};
  }
}

void TrackStage::finish(Entry& entry) OVWS_NONBLOCKING {
  if (history_.live()) retry_lost(entry);
  if (entry.settled) {
    search_if_needed(entry);
    history_.learn(entry);
  }
  summarise(entry);
  entry.release_pixels();
}

void TrackStage::retry_lost(Entry& entry) OVWS_NONBLOCKING {
  const Neighbourhood& neighbourhood = entry.measurement->neighbourhood;
  const std::span<SpotFix> spots = spots_of(entry);
  // Of two subapertures that claim one spot, nobody knows yet whose it is: both are asked again.
  for (int i = 0; i < entry.spot_count; ++i) doubled_[i] = neighbourhood.doubled(i, spots);
  for (int i = 0; i < entry.spot_count; ++i) {
    if (doubled_[i]) spots[i] = SpotFix{};
  }
  const int found = count_found(spots);
  if (found == entry.spot_count || found == 0) return;
  const DisplacementField field = neighbourhood.fit(spots);
  TrackScratch& scratch = entry.measurement->track_scratch[0];
  for (int i = 0; i < entry.spot_count; ++i) {
    if (spots[i].found()) continue;
    const Vec2 start_px = neighbourhood.expect(i, field, spots);
    spots[i] = entry.plan->tracker->track(entry.frame.image, start_px, scratch);
    if (neighbourhood.doubled(i, spots)) spots[i] = SpotFix{};
  }
}

void TrackStage::search_if_needed(Entry& entry) OVWS_NONBLOCKING {
  const int found = count_found(spots_of(entry));
  if (history_.live() && entry.spot_count - found <= few(entry.spot_count)) {
    search_back_off_.reset();
  } else if (search_back_off_.try_now()) {
    search(entry, found);
  }
}

void TrackStage::search(Entry& entry, int found) OVWS_NONBLOCKING {
  deps_.counters.add(Counter::acquisitions);
  const std::span<SpotFix> searched{searched_.data(), std::size_t(entry.spot_count)};
  const int searched_found = entry.measurement->acquisition.acquire(
      entry.frame.image, *entry.plan->tracker, entry.measurement->track_scratch[0], searched);
  if (searched_found > found && searched_found >= credible(entry.spot_count)) {
    std::copy(searched.begin(), searched.end(), entry.spots.begin());
  }
}

void TrackStage::summarise(Entry& entry) OVWS_NONBLOCKING {
  const std::span<const SpotFix> spots = spots_of(entry);
  const auto full = float((1 << significant_bits(entry.frame.image.format)) - 1);
  const auto saturated =
      std::count_if(spots.begin(), spots.end(), [&](const SpotFix& s) { return s.peak >= full; });
  entry.tracked = count_found(spots);
  entry.saturated_fraction = spots.empty() ? 0.0F : float(saturated) / float(entry.spot_count);
  deps_.counters.add(Counter::spots_lost, std::uint64_t(entry.spot_count - entry.tracked));
  entry.t_tracked_mono_ns = monotonic_ns();
  deps_.latency.record(entry.t_tracked_mono_ns - entry.frame.t_arrival_mono_ns);
}

}  // namespace ovws
