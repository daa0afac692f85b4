#include "daemon/spot_finder.hpp"

#include <algorithm>
#include <chrono>
#include <new>
#include <thread>
#include <utility>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/wavefront/shape_templates.hpp"
#include "core/wavefront/shaped_acquisition.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/plan_builder.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kTurn(50);
constexpr int kInARow = 5;  // doubtful frames: noise loses a spot now and then
constexpr std::int64_t kPauseNs = 500'000'000;
constexpr std::int64_t kLongestPauseNs = 30'000'000'000;
constexpr double kMostResidual = 0.03;  // lambda/d, RMS of what no mode explains of the positions
// Memory is locked: what a search needs grows with both, to some hundred MiB here.
constexpr std::size_t kMostSpots = 200;
constexpr double kMostSpotPx = 40.0;  // lambda/d

/// A torn spot may be lost, or found in its wrong half: then no wavefront explains the positions.
bool is_doubtful(const FrameRecord& record) {
  const double explained_px = kMostResidual * record.plan->spots.lambda_d_px;
  return record.settled && (record.tracked < record.spot_count ||
                            record.reconstruction.fit_residual_px > explained_px);
}

}  // namespace

/// All that one sensor's images of one size need.
struct SpotFinder::Bench {
  SensorConfig sensor;
  TrackingConfig tracking;
  int cols = 0, rows = 0;
  PxPerCycle px_per_cycle;
  std::vector<Vec2> reference_px;
  std::unique_ptr<const SpotTracker> tracker;
  TrackScratch scratch;
  SpotModel spots;
  ShapedAcquisition acquisition;
  SpotOptics optics;  ///< of templates
};

SpotFinder::SpotFinder(const SlmGeometry& slm, Instrument& instrument)
    : slm_(slm), instrument_(instrument), inbox_(is_doubtful), pause_ns_(kPauseNs) {}

SpotFinder::~SpotFinder() = default;

void SpotFinder::saw(const FrameRecord& record) {
  if (!record.settled) return;
  doubtful_in_a_row_ = is_doubtful(record) ? doubtful_in_a_row_ + 1 : 0;
  doubtful_.store(doubtful_in_a_row_ >= kInARow, std::memory_order_relaxed);
}

bool SpotFinder::do_work() {
  if (!doubtful_ || monotonic_ns() < next_ns_) {
    if (!doubtful_) pause_ns_ = kPauseNs, next_ns_ = 0;
    inbox_.forget();
    std::this_thread::sleep_for(kTurn);
    return false;
  }
  const FrameCopy* const frame = inbox_.next(kTurn);
  if (frame == nullptr) return false;
  const SensorSnapshot sensor = instrument_.snapshot();
  if (frame->plan_id != sensor.plan_id) return false;  // the sensor has changed since
  std::optional<TornSpots> torn = search(*frame, sensor);
  const bool news = torn && sensor.torn.empty();
  pause_ns_ = news ? kPauseNs : std::min(2 * pause_ns_, kLongestPauseNs);
  instrument_.follow(sensor.plan_id, std::move(torn));
  next_ns_ = monotonic_ns() + pause_ns_;
  return true;
}

std::optional<TornSpots> SpotFinder::search(const FrameCopy& frame, const SensorSnapshot& sensor) {
  try {
    return make_bench(frame, sensor) ? explain(frame) : std::nullopt;
  } catch (const std::bad_alloc&) {
    bench_.reset();  // the ordinary plan needs nothing more
    return std::nullopt;
  }
}

std::optional<TornSpots> SpotFinder::explain(const FrameCopy& frame) {
  std::vector<SpotFix> fixes(bench_->reference_px.size());
  ShapedAcquisition& acquisition = bench_->acquisition;
  acquisition.acquire(frame.image, *bench_->tracker, bench_->scratch, fixes, false);
  const std::vector<bool>& torn = acquisition.torn();
  if (std::none_of(torn.begin(), torn.end(), [](bool one) { return one; })) return std::nullopt;
  TornSpots out;
  for (const ShapedSpot& spot : acquisition.shapes()) out.at_px.push_back(spot.at_px);
  out.templates =
      shape_templates(bench_->optics, bench_->spots.on_lattice(), acquisition.waves(), torn);
  return out;
}

/// False: what stands in the snapshot makes no sensor, or one too large to search.
bool SpotFinder::make_bench(const FrameCopy& frame, const SensorSnapshot& sensor) {
  const int cols = frame.image.width, rows = frame.image.height;
  const auto lattice = make_lattice(sensor.sensor, slm_);
  if (!lattice) return false;
  const PxPerCycle map = px_per_cycle(sensor.optics, slm_);
  std::vector<Vec2> reference_px =
      sensor.reference ? sensor.reference->positions_px
                       : model_spots_px(*lattice, sensor.sensor, slm_, sensor.optics, cols, rows);
  const SpotModel spots = spot_model(sensor.sensor, sensor.optics, slm_, frame.image.format);
  const bool same = bench_ && bench_->sensor == sensor.sensor &&
                    bench_->tracking == sensor.tracking && bench_->cols == cols &&
                    bench_->rows == rows && bench_->reference_px == reference_px &&
                    bench_->px_per_cycle == map && bench_->spots == spots;
  if (same) return true;
  bench_.reset();
  if (reference_px.size() > kMostSpots || spots.lambda_d_px > kMostSpotPx) return false;
  auto tracker = make_tracker(sensor.tracking, spots);
  if (!tracker) return false;
  const Eigen::MatrixXd slopes =
      slope_matrix(*lattice, sensor.sensor, sensor.modes_j,
                   slope_model(sensor.sensor.charge, sensor.tracking), map);
  TrackScratch scratch = (*tracker)->make_scratch();
  bench_ = std::make_unique<Bench>(
      Bench{sensor.sensor, sensor.tracking, cols, rows, map, reference_px, std::move(*tracker),
            std::move(scratch), spots,
            ShapedAcquisition(*lattice, sensor.sensor, spots, map, sensor.modes_j, slopes,
                              reference_px, cols, rows),
            template_optics(*lattice, sensor.sensor, sensor.modes_j, map / spots.lit.lattice.step,
                            spots.on_lattice())});
  return true;
}

}  // namespace ovws
