/// Connects the stages and provides the agents that run them.
#include "core/pipeline/pipeline.hpp"

#include <algorithm>
#include <chrono>

#include "core/pipeline/camera_exchange.hpp"
#include "core/pipeline/ingest.hpp"
#include "core/pipeline/outbox.hpp"
#include "core/pipeline/plan_exchange.hpp"
#include "core/pipeline/reconstruct_stage.hpp"
#include "core/pipeline/record_pool.hpp"
#include "core/pipeline/track_stage.hpp"
#include "core/pipeline/tracker_crew.hpp"

namespace ovws {
namespace {

using namespace std::chrono_literals;

constexpr int kMinRecords = 4;

class InlineAgent final : public Agent {
 public:
  InlineAgent(Ingest& ingest, TrackStage& track, ReconstructStage& reconstruct)
      : ingest_(ingest), track_(track), reconstruct_(reconstruct) {}

  bool do_work() override {
    bool idle = false;
    Entry* const entry = ingest_.run_once(idle);
    if (entry == nullptr) return !idle;
    track_.begin(*entry);
    track_.track_slice(*entry, 0);
    track_.finish(*entry);
    ingest_.return_buffers();
    reconstruct_.run(*entry);
    return true;
  }

 private:
  Ingest& ingest_;
  TrackStage& track_;
  ReconstructStage& reconstruct_;
};

class AcquisitionAgent final : public Agent {
 public:
  AcquisitionAgent(Ingest& ingest, TrackerCrew& crew) : ingest_(ingest), crew_(crew) {}

  bool do_work() override {
    bool idle = false;
    Entry* const entry = ingest_.run_once(idle);
    if (entry != nullptr) crew_.submit(*entry);
    return !idle;
  }

 private:
  Ingest& ingest_;
  TrackerCrew& crew_;
};

class TrackerAgent final : public Agent {
 public:
  TrackerAgent(TrackerCrew& crew, int k) : crew_(crew), k_(k) {}
  bool do_work() override { return crew_.run_worker(k_); }

 private:
  TrackerCrew& crew_;
  int k_;
};

class ReconstructionAgent final : public Agent {
 public:
  ReconstructionAgent(SpscRing<Entry*>& tracked, ReconstructStage& stage)
      : tracked_(tracked), stage_(stage) {}

  bool do_work() override {
    Entry* entry = nullptr;
    if (!tracked_.pop(entry, 20ms)) return false;
    stage_.run(*entry);
    return true;
  }

 private:
  SpscRing<Entry*>& tracked_;
  ReconstructStage& stage_;
};

}  // namespace

struct Pipeline::Impl {
  Impl(const PipelineConfig& config, const PipelineDeps& deps)
      : workers(std::max(config.workers, 0)),
        records(std::max(config.records, kMinRecords)),
        pool(records),
        plans(pool, workers),
        tap(records),
        ingest(
            {deps.counters, deps.shown, deps.settings, cameras, plans, pool, tap, arrived_latency}),
        track({std::max(workers, 1)}, {deps.counters, tracked_latency}),
        tracked(std::size_t(records)),
        crew({workers, records}, {track, tracked}),
        outbox(records, deps.counters, tap),
        reconstruct({reconstructed_latency, outbox}),
        reconstruction(tracked, reconstruct) {
    if (workers == 0) {
      acquisition = std::make_unique<InlineAgent>(ingest, track, reconstruct);
    } else {
      acquisition = std::make_unique<AcquisitionAgent>(ingest, crew);
    }
    for (int k = 0; k < workers; ++k) trackers.push_back(std::make_unique<TrackerAgent>(crew, k));
  }

  const int workers;
  const int records;
  LatencyHistogram arrived_latency;
  LatencyHistogram tracked_latency;
  LatencyHistogram reconstructed_latency;
  RecordPool pool;
  PlanExchange plans;
  RecordTap tap;
  CameraExchange cameras;
  Ingest ingest;
  TrackStage track;
  SpscRing<Entry*> tracked;
  TrackerCrew crew;
  Outbox outbox;
  ReconstructStage reconstruct;
  std::unique_ptr<Agent> acquisition;
  std::vector<std::unique_ptr<Agent>> trackers;
  ReconstructionAgent reconstruction;
};

Pipeline::Pipeline(const PipelineConfig& config, const PipelineDeps& deps)
    : impl_(std::make_unique<Impl>(config, deps)) {}
Pipeline::~Pipeline() = default;

Agent& Pipeline::acquisition() {
  return *impl_->acquisition;
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

// Every record that leaves the pool is an Entry.
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
                      bool searched) {
  impl_->track.resume(plan, starts, follows, searched);
}

LatencyHistogram& Pipeline::arrived_latency() {
  return impl_->arrived_latency;
}
LatencyHistogram& Pipeline::tracked_latency() {
  return impl_->tracked_latency;
}
LatencyHistogram& Pipeline::reconstructed_latency() {
  return impl_->reconstructed_latency;
}

}  // namespace ovws
