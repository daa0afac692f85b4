/// Spot tracking in three levels: history, affine fit to the neighbours, whole-image search.
#include "core/pipeline/track_stage.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include "core/optics/lattice.hpp"
#include "core/pipeline/measurement.hpp"
#include "core/port/clock.hpp"
#include "core/tracking/patch.hpp"

namespace ovws {
namespace {

std::span<SpotFix> spots_of(Entry& entry) {
  return {entry.spots.data(), std::size_t(entry.spot_count)};
}

void lose_spots(Entry& entry) OVWS_NONBLOCKING {
  entry.spot_count = entry.plan->subapertures();
  std::ranges::fill(spots_of(entry), SpotFix{});
  std::ranges::fill_n(entry.starts.begin(), entry.spot_count, SpotStart{});
  entry.searched = false;
  entry.templates = {};
  entry.follows = false;
  entry.saturated_fraction = 0.0F;
  entry.t_tracked_mono_ns = monotonic_ns();
}

int count_found(std::span<const SpotFix> spots) {
  return int(std::count_if(spots.begin(), spots.end(), [](const SpotFix& s) { return s.found(); }));
}

}  // namespace

TrackStage::TrackStage(int slices, Counters& counters, LatencyHistogram& latency)
    : slices_(slices),
      counters_(counters),
      latency_(latency),
      duplicate_(kMaxSubapertures),
      searched_(kMaxSubapertures) {}

void TrackStage::begin(Entry& entry) OVWS_NONBLOCKING {
  entry.spot_count = entry.plan->subapertures();
  entry.searched = false;
  if (history_.fit_to(*entry.plan)) search_back_off_.reset();
  watch_settings(entry);
  history_.starts(entry, entry.starts);
}

/// Restarts the search's backoff when gain or exposure have changed: spots that were too dark or
/// too bright may be found now.
void TrackStage::watch_settings(const FrameStamp& frame) OVWS_NONBLOCKING {
  if (!frame.settings_known) return;
  const CameraSettings before = known_;
  known_.gain_db = frame.gain_db;
  known_.gain_raw = frame.gain_raw;
  known_.exposure_us = frame.exposure_us;
  const bool same = same_gain(before, known_) && before.exposure_us == known_.exposure_us;
  if (!same) search_back_off_.reset();
}

void TrackStage::resume(const MeasurementPlan& plan, std::span<const SpotStart> starts,
                        bool follows, bool searched) {
  history_.resume(plan, starts, follows);
  forced_search_ = searched;
}

void TrackStage::track_slice(Entry& entry, int k) OVWS_NONBLOCKING {
  const int begin = entry.spot_count * k / slices_;
  const int end = entry.spot_count * (k + 1) / slices_;
  Measurement& measurement = *entry.measurement;
  if (!entry.plan->fit) return track(entry, begin, end, measurement.track_scratch[k]);
  const SpotFit& spots = entry.plan->fit->spots();
  for (int i = begin; i < end; ++i) {
    entry.estimates[i] = spots.fit(entry.frame.image, std::size_t(i), measurement.fit_scratch[k]);
  }
}

void TrackStage::track(Entry& entry, int begin, int end, TrackScratch& scratch) OVWS_NONBLOCKING {
  for (int i = begin; i < end; ++i) {
    const SpotStart& start = entry.starts[i];
    entry.spots[i] = start.fresh
                         ? entry.plan->tracker_of(i).track(entry.frame.image, start.at_px, scratch)
                         : SpotFix{};
  }
}

/// Measures by the plan's templates. If they do not describe the frame, tracks the spots with fresh
/// starts; the others are lost.
void TrackStage::fit(Entry& entry) OVWS_NONBLOCKING {
  const auto count = std::size_t(entry.spot_count), modes = entry.plan->fit->modes_j().size();
  entry.templates = entry.plan->fit->solve(
      {entry.estimates.data(), count}, entry.measurement->solve_scratch,
      {entry.coefficients.data(), modes}, {entry.sigma_waves.data(), modes}, spots_of(entry));
  if (entry.templates.credible) return;
  track(entry, 0, entry.spot_count, entry.measurement->track_scratch[0]);
}

void TrackStage::finish(Entry& entry) OVWS_NONBLOCKING {
  entry.templates = {};
  entry.follows = false;
  if (entry.plan->fit) fit(entry);
  if (history_.live() && !entry.templates.credible) {
    reject_implausible(entry);
    retry_lost(entry);
  }
  if (entry.settled) {
    if (!entry.templates.credible) search_if_needed(entry);
    entry.follows = history_.is_followed_by(entry);
    history_.learn(entry);
  }
  summarise(entry);
}

void TrackStage::reject_implausible(Entry& entry) OVWS_NONBLOCKING {
  const Neighbourhood& neighbourhood = entry.measurement->neighbourhood;
  const std::span<SpotFix> spots = spots_of(entry);
  drop_faint(spots, entry.spot_count, entry.plan->levels());
  // Two subapertures that track the same spot are ambiguous: drop both fixes and track again.
  for (int i = 0; i < entry.spot_count; ++i) duplicate_[i] = neighbourhood.is_duplicate(i, spots);
  for (int i = 0; i < entry.spot_count; ++i) {
    if (duplicate_[i]) spots[i] = SpotFix{};
  }
}

void TrackStage::retry_lost(Entry& entry) OVWS_NONBLOCKING {
  const Neighbourhood& neighbourhood = entry.measurement->neighbourhood;
  const std::span<SpotFix> spots = spots_of(entry);
  const int found = count_found(spots);
  if (found == entry.spot_count || found == 0) return;
  const DisplacementField field = neighbourhood.fit(spots);
  for (int i = 0; i < entry.spot_count; ++i) {
    if (spots[i].found()) continue;
    spots[i] = retry(entry, i, neighbourhood.expect(i, field, spots));
  }
  drop_faint(spots, entry.spot_count, entry.plan->levels());
}

/// Tracks a lost spot again: first from the remembered position if it agrees with the neighbours,
/// then from the position expected from the neighbours.
SpotFix TrackStage::retry(Entry& entry, int i, Vec2 expected_px) OVWS_NONBLOCKING {
  const Neighbourhood& neighbourhood = entry.measurement->neighbourhood;
  TrackScratch& scratch = entry.measurement->track_scratch[0];
  const std::span<SpotFix> spots = spots_of(entry);
  const SpotTracker& tracker = entry.plan->tracker_of(i);
  const Vec2 remembered_px = entry.starts[i].at_px;
  const double apart_px = norm(remembered_px - expected_px);  // NaN without a remembered position
  if (!entry.starts[i].fresh && apart_px < 0.5 * neighbourhood.pitch_px(i)) {
    spots[i] = tracker.track(entry.frame.image, remembered_px, scratch);
    if (spots[i].found() && !neighbourhood.is_duplicate(i, spots)) return spots[i];
  }
  spots[i] = tracker.track(entry.frame.image, expected_px, scratch);
  return neighbourhood.is_duplicate(i, spots) ? SpotFix{} : spots[i];
}

void TrackStage::search_if_needed(Entry& entry) OVWS_NONBLOCKING {
  const int found = count_found(spots_of(entry));
  if (const auto forced = std::exchange(forced_search_, std::nullopt)) {
    if (*forced) search(entry, found);
  } else if (history_.live() && entry.spot_count - found <= few(entry.spot_count)) {
    search_back_off_.reset();
  } else if (search_back_off_.try_now()) {
    search(entry, found);
  }
}

void TrackStage::search(Entry& entry, int found) OVWS_NONBLOCKING {
  counters_.add(Counter::acquisitions);
  entry.searched = true;
  const std::span<SpotFix> searched{searched_.data(), std::size_t(entry.spot_count)};
  const int searched_found = entry.measurement->acquisition.acquire(
      entry.frame.image, *entry.plan->tracker, entry.measurement->track_scratch[0], searched);
  if (searched_found > found) std::copy(searched.begin(), searched.end(), entry.spots.begin());
}

void TrackStage::summarise(Entry& entry) OVWS_NONBLOCKING {
  const std::span<SpotFix> spots = spots_of(entry);
  // Saturation can make spots get lost, so lost spots count for the saturated fraction, too.
  const int half_px = int(entry.plan->spots.lambda_d_px);
  for (int i = 0; i < entry.spot_count; ++i) {
    if (spots[i].found() || spots[i].peak > 0.0F) continue;
    spots[i].peak = brightest_pixel(entry.frame.image, entry.plan->predicted_px[i], half_px);
  }
  const double full = full_scale_dn(entry.frame.image.format);
  const auto saturated = std::count_if(spots.begin(), spots.end(),
                                       [&](const SpotFix& s) { return double(s.peak) >= full; });
  entry.tracked = count_found(spots);
  entry.saturated_fraction = spots.empty() ? 0.0F : float(saturated) / float(entry.spot_count);
  counters_.add(Counter::spots_lost, std::uint64_t(entry.spot_count - entry.tracked));
  entry.t_tracked_mono_ns = monotonic_ns();
  if (!entry.plan->beam.empty()) return;
  latency_.record(entry.t_tracked_mono_ns - entry.frame.t_arrival_mono_ns);
}

TrackStages::TrackStages(Most most, int slices, Counters& counters, LatencyHistogram& latency) {
  for (int k = 0; k <= most.beams; ++k) stages_.emplace_back(slices, counters, latency);
  for (int k = 0; k < most.patterns; ++k) patterns_.emplace_back(slices, counters, latency);
}

/// The main source's stage for this frame; nullptr: its pattern is uncertain.
TrackStage* TrackStages::main_of(const Entry& entry) OVWS_NONBLOCKING {
  if (!entry.plan->patterns.empty()) return nullptr;
  return entry.pattern < 0 ? &stages_[0] : &patterns_[std::size_t(entry.pattern)];
}

void TrackStages::begin(Entry& entry) OVWS_NONBLOCKING {
  TrackStage* const main = main_of(entry);
  if (main == nullptr) return lose_spots(entry);
  main->begin(entry);
  for (std::size_t k = 0; k < entry.plan->beams.size(); ++k) {
    stages_[k + 1].begin(beam_of(entry, k));
  }
}

void TrackStages::track_slice(Entry& entry, int slice) OVWS_NONBLOCKING {
  TrackStage* const main = main_of(entry);
  if (main == nullptr) return;
  main->track_slice(entry, slice);
  for (std::size_t k = 0; k < entry.plan->beams.size(); ++k) {
    stages_[k + 1].track_slice(beam_of(entry, k), slice);
  }
}

void TrackStages::finish(Entry& entry) OVWS_NONBLOCKING {
  if (TrackStage* const main = main_of(entry)) main->finish(entry);
  for (std::size_t k = 0; k < entry.plan->beams.size(); ++k) {
    stages_[k + 1].finish(beam_of(entry, k));
  }
  entry.release_pixels();
}

void TrackStages::resume(const MeasurementPlan& plan, std::span<const SpotStart> starts,
                         bool follows, unsigned searched) {
  const auto spots = std::size_t(plan.subapertures());
  stages_[0].resume(plan, starts.first(spots), follows, (searched & 1U) != 0);
  starts = starts.subspan(spots);
  for (std::size_t k = 0; k < plan.beams.size(); ++k) {
    const MeasurementPlan& beam = *plan.beams[k];
    searched >>= 1U;
    // Beams have no templates, so it does not matter whether the frame before follows.
    stages_[k + 1].resume(beam, starts.first(std::size_t(beam.subapertures())), false,
                          (searched & 1U) != 0);
    starts = starts.subspan(std::size_t(beam.subapertures()));
  }
}

}  // namespace ovws
