/// Connects the stages and provides the agents that run them.
#include "core/pipeline/pipeline.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include "core/pipeline/camera_exchange.hpp"
#include "core/pipeline/frame_rules.hpp"
#include "core/pipeline/ingest.hpp"
#include "core/pipeline/measurement.hpp"
#include "core/pipeline/outbox.hpp"
#include "core/pipeline/plan_exchange.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/pipeline/track_stage.hpp"
#include "core/pipeline/tracker_crew.hpp"
#include "core/port/clock.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

constexpr int kMinRecords = 4;

/// Agent that calls a function on every iteration.
class Duty final : public Agent {
 public:
  explicit Duty(std::function<bool()> turn) : turn_(std::move(turn)) {}
  bool do_work() override { return turn_(); }

 private:
  std::function<bool()> turn_;
};

}  // namespace

struct Pipeline::Impl {
  Impl(const PipelineConfig& config, const PipelineDeps& deps)
      : workers(std::max(config.workers, 0)),
        records(std::max(config.records, kMinRecords)),
        pool(records, config.beams),
        plans(pool, workers),
        tap(records),
        ingest({deps.counters, deps.shown, deps.settings, cameras, plans, pool, tap,
                latencies.arrived}),
        track({config.beams, config.patterns}, std::max(workers, 1), deps.counters,
              latencies.tracked),
        tracked(std::size_t(records)),
        crew(workers, records, track, tracked),
        outbox(records, deps.counters, tap) {
    for (int k = 0; k < workers; ++k) {
      trackers.push_back(std::make_unique<Duty>([this, k] { return crew.run_worker(k); }));
    }
  }

  bool acquire();
  bool reconstruct_next();
  void reconstruct(Entry& entry) OVWS_NONBLOCKING;
  void measure(Entry& entry) OVWS_NONBLOCKING;
  static void part(Entry& one, Entry& other) OVWS_NONBLOCKING;

  const int workers;
  const int records;
  Latencies latencies;
  RecordPool pool;
  PlanExchange plans;
  RecordTap tap;
  CameraExchange cameras;
  Ingest ingest;
  TrackStages track;
  SpscRing<Entry*> tracked;
  TrackerCrew crew;
  Outbox outbox;
  Duty acquisition{[this] { return acquire(); }};
  std::vector<std::unique_ptr<Duty>> trackers;
  Duty reconstruction{[this] { return reconstruct_next(); }};
};

/// One iteration of the acquisition thread. Without tracker workers it runs all stages.
bool Pipeline::Impl::acquire() {
  bool idle = false;
  Entry* const entry = ingest.run_once(idle);
  if (entry == nullptr) return !idle;
  if (workers > 0) {
    crew.submit(*entry);
    return true;
  }
  track.begin(*entry);
  track.track_slice(*entry, 0);
  track.finish(*entry);
  ingest.return_buffers();
  reconstruct(*entry);
  return true;
}

bool Pipeline::Impl::reconstruct_next() {
  Entry* entry = nullptr;
  if (!tracked.pop(entry, 20ms)) return false;
  reconstruct(*entry);
  return true;
}

/// Last stage: measures the modes of all light sources. Call it in frame order, from one thread at
/// a time. The caller must not use the record afterwards.
void Pipeline::Impl::reconstruct(Entry& entry) OVWS_NONBLOCKING {
  measure(entry);
  latencies.reconstructed.record(entry.t_reconstructed_mono_ns - entry.frame.t_arrival_mono_ns);
  for (std::size_t k = 0; k < entry.plan->beams.size(); ++k) measure(beam_of(entry, k));
  for (std::size_t k = 0; k < entry.plan->beams.size(); ++k) {
    Entry& beam = beam_of(entry, k);
    part(entry, beam);
    for (std::size_t l = 0; l < k; ++l) part(beam_of(entry, l), beam);
  }
  outbox.put(entry);
}

/// Makes the measurements of two sources invalid if their spots have come too close.
void Pipeline::Impl::part(Entry& one, Entry& other) OVWS_NONBLOCKING {
  if (are_apart(one, other)) return;
  for (Entry* const entry : {&one, &other}) {
    entry->explained = entry->explained && !entry->valid;
    entry->valid = false;
    entry->verdict = verdict_of(*entry, true);
  }
}

/// Reconstructs the modes of one source from its spots, unless templates have measured them, and
/// decides whether they are valid.
void Pipeline::Impl::measure(Entry& entry) OVWS_NONBLOCKING {
  const MeasurementPlan& plan = *entry.plan;
  entry.mode_count = int(plan.modes_j.size());
  const std::span<SpotFix> spots{entry.spots.data(), std::size_t(entry.spot_count)};
  entry.branch_points.count = 0;
  if (entry.templates.credible) {
    const std::size_t modes = plan.modes_j.size();
    entry.reconstruction =
        reconstruction_of(entry.templates, plan.modes_j, {entry.coefficients.data(), modes});
  } else {
    std::fill_n(entry.coefficients.begin(), entry.mode_count, NAN);
    std::fill_n(entry.sigma_waves.begin(), entry.mode_count, NAN);
    entry.reconstruction =
        reconstruct_positions(plan, spots, entry.measurement->reconstruct_scratch,
                              entry.measurement->left_px, entry.coefficients, entry.branch_points);
  }
  entry.tracked = int(
      std::count_if(spots.begin(), spots.end(), [](const SpotFix& spot) { return spot.found(); }));
  const bool measured = entry.settled && entry.reconstruction.determined && plan.referenced();
  const bool by_positions =
      measured && is_explained(entry.reconstruction, spots, plan.spots.lambda_d_px);
  const bool by_templates =
      plan.tracker_kind == TrackerKind::fit && (plan.fit != nullptr || plan.awaits_templates);
  const bool suffices = plan.positions_suffice() && (!by_templates || entry.follows);
  entry.unconfirmed = by_positions && !entry.templates.credible && !suffices;
  entry.explained = !measured || entry.templates.credible ||
                    (by_positions && !entry.unconfirmed && entry.branch_points.count == 0);
  entry.valid = measured && entry.explained;
  entry.verdict = verdict_of(entry);
  entry.t_reconstructed_mono_ns = monotonic_ns();
}

Pipeline::Pipeline(const PipelineConfig& config, const PipelineDeps& deps)
    : impl_(make_hidden<Impl>(config, deps)) {}

Agent& Pipeline::acquisition() {
  return impl_->acquisition;
}
Agent& Pipeline::tracker(int k) {
  return *impl_->trackers.at(std::size_t(k));
}
Agent& Pipeline::reconstruction() {
  return impl_->reconstruction;
}

void Pipeline::use_plan(const MeasurementPlan* plan) {
  impl_->plans.offer(plan);
}
std::uint64_t Pipeline::oldest_plan_in_use() const {
  return impl_->plans.oldest_in_use();
}
Result<void> Pipeline::attach(Camera& camera) {
  return impl_->cameras.attach(camera);
}
Result<void> Pipeline::detach() {
  return impl_->cameras.detach();
}
std::int64_t Pipeline::last_frame_mono_ns() const {
  return impl_->ingest.last_frame_mono_ns();
}
std::int64_t Pipeline::last_sign_mono_ns() const {
  return impl_->ingest.last_sign_mono_ns();
}

// Downcasts to Entry are safe: every record that leaves the pool is an Entry.
FrameRecord* Pipeline::next(int timeout_us) {
  return impl_->outbox.next(timeout_us);
}
void Pipeline::release(FrameRecord* record) {
  impl_->outbox.release(static_cast<Entry&>(*record));
}

void Pipeline::request_image() {
  impl_->ingest.request_image();
}
FrameRecord* Pipeline::next_image(int timeout_us) {
  return impl_->outbox.next_image(timeout_us);
}
void Pipeline::release_image(FrameRecord* record) {
  impl_->outbox.release_image(static_cast<Entry&>(*record));
}

void Pipeline::record(int pixels_every) {
  impl_->tap.open(pixels_every);
}
void Pipeline::stop_recording() {
  impl_->tap.close();
}
FrameRecord* Pipeline::next_recorded(int timeout_us) {
  return impl_->tap.next(timeout_us);
}
bool Pipeline::has_recorded_pixels(const FrameRecord& record) {
  return static_cast<const Entry&>(record).pixels_recorded;
}
void Pipeline::release_recorded(FrameRecord* record) {
  impl_->tap.release(static_cast<Entry&>(*record));
}

void Pipeline::resume(const MeasurementPlan& plan, std::span<const SpotStart> starts, bool follows,
                      unsigned searched) {
  impl_->track.resume(plan, starts, follows, searched);
}

Latencies& Pipeline::latencies() {
  return impl_->latencies;
}

}  // namespace ovws
