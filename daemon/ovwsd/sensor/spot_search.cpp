#include "daemon/ovwsd/sensor/spot_search.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <thread>
#include <utility>

#include "core/optics/lattice.hpp"
#include "core/port/clock.hpp"
#include "core/tracking/binned_image.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "core/wavefront/shape_templates.hpp"
#include "core/wavefront/shaped_acquisition.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/ovwsd/sensor/reference_spots.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kTurn(10);
constexpr std::chrono::milliseconds kFramePatience(50);
constexpr int kBlindInARow = 2;
constexpr int kDoubtfulInARow = 5;  // valid frames: noise may lose a spot occasionally
constexpr std::int64_t kCheckPauseNs = 50'000'000;
constexpr std::int64_t kAdoptPatienceNs = 300'000'000;
constexpr std::int64_t kRecoveredNs = 1'000'000'000;
constexpr std::int64_t kAnnounceNs = 500'000'000;
constexpr double kMaxResidual = 0.03;  // lambda/d: RMS fit residual of the positions
constexpr double kMaxOffset = 0.5;     // lambda/d
constexpr double kCell = 0.5;          // lambda/d: images are compared after binning to this size
// Limits of the search's memory, which is locked and grows with both: some hundred MiB here.
constexpr std::size_t kMaxSpots = 200;
constexpr double kMaxSpotPx = 40.0;  // lambda/d, camera pixels

/// Whether a frame needs a search. A split spot is lost, or a wrong fragment of it is tracked,
/// which raises the fit residual. Spots that the reference lacks do not count: they are dark.
bool is_doubtful(const FrameRecord& record) {
  const double explained_px = kMaxResidual * record.plan->spots.lambda_d_px;
  const int lost =
      record.plan->referenced() ? record.reconstruction.lost : record.spot_count - record.tracked;
  return record.settled && (lost > 0 || record.reconstruction.fit_residual_px > explained_px);
}

/// Positions of the spots; NaN for lost ones.
std::vector<Vec2> positions(std::span<const SpotFix> fixes) {
  std::vector<Vec2> at_px;
  for (const SpotFix& fix : fixes) at_px.push_back({double(fix.x), double(fix.y)});
  return at_px;
}

/// Whether a new plan would measure the same: no spot is split, and each spot of the reference is
/// already tracked where the search found it.
bool is_tracked_already(const SplitSpots& found, const FrameCopy& frame,
                        const SensorSnapshot& sensor, double lambda_d_px) {
  if (!sensor.split.empty() || !found.numbers().empty() || !sensor.reference) return false;
  const std::vector<Vec2> reference_px = known_positions(*sensor.reference);
  for (std::size_t i = 0; i < reference_px.size(); ++i) {
    const Vec2 tracked_px{double(frame.spots[i].x), double(frame.spots[i].y)};
    const bool there = norm(found.at_px[i] - tracked_px) <= kMaxOffset * lambda_d_px;
    if (!std::isnan(reference_px[i].x) && !there) return false;
  }
  return true;
}

}  // namespace

/// What a search needs; rebuilt when the sensor or the image size changes.
struct SpotSearch::Bench {
  SensorConfig sensor;
  TrackingConfig tracking;
  int cols = 0, rows = 0;
  PxPerCycle px_per_cycle;
  std::vector<Vec2> reference_px;
  std::unique_ptr<const SpotTracker> tracker;
  TrackScratch scratch;
  SpotModel spots;
  ShapedAcquisition acquisition;
  SpotOptics optics;  ///< for templates of split spots
  Reconstructor plain;
};

SpotSearch::SpotSearch(const SlmGeometry& slm, FrameBroker& frames, SensorKeeper& keeper,
                       Events& events)
    : slm_(slm), keeper_(keeper), events_(events), inbox_(frames, is_doubtful) {}

SpotSearch::~SpotSearch() = default;

void SpotSearch::on_frame(const FrameRecord& record) {
  if (!record.settled) return;
  const bool doubtful = is_doubtful(record);
  const bool blind = doubtful && !record.valid && record.plan->referenced();
  doubtful_in_a_row_ = doubtful ? doubtful_in_a_row_ + 1 : 0;
  blind_in_a_row_ = blind ? blind_in_a_row_ + 1 : 0;
  const Doubt doubt = blind_in_a_row_ >= kBlindInARow         ? Doubt::blind
                      : doubtful_in_a_row_ >= kDoubtfulInARow ? Doubt::partial
                                                              : Doubt::none;
  doubt_.store(doubt, std::memory_order_relaxed);
  if (!record.plan->referenced()) return;
  validity_.on_frame(record.valid,
                     {0, record.tracked, record.spot_count, record.explained, record.unconfirmed},
                     monotonic_ns());
}

std::optional<StatusMessage::SensorPart::Invalid> SpotSearch::why_invalid() const {
  const std::int64_t now_ns = monotonic_ns();
  const auto lack = validity_.lack(now_ns);
  if (!lack) return std::nullopt;
  return invalid_in_words(*lack, progress_.get(), now_ns, utc_ns());
}

/// Publishes an event when no frame has been valid for kAnnounceNs, and when frames are valid
/// again.
void SpotSearch::announce() {
  const std::int64_t now_ns = monotonic_ns();
  const auto lack = validity_.lack(now_ns);
  if (lack && announced_ns_ == 0 && now_ns - lack->since_ns >= kAnnounceNs) {
    announced_ns_ = lack->since_ns;
    const auto why = invalid_in_words(*lack, progress_.get(), now_ns, utc_ns());
    events_.emit("spots", Severity::warning,
                 fmt::format("no frame has been valid for {:.1f} s: {}; {}",
                             1e-9 * double(now_ns - lack->since_ns), why.reason, why.action),
                 {{"valid", false}, {"tracked", lack->tracked}, {"searches", why.searches}});
  }
  if (announced_ns_ == 0 || !validity_.is_valid()) return;
  events_.emit(
      "spots", Severity::info,
      fmt::format("frames are valid again, after {:.1f} s", 1e-9 * double(now_ns - announced_ns_)),
      {{"valid", true}});
  announced_ns_ = 0;
}

bool SpotSearch::do_work() {
  const Doubt doubt = doubt_.load(std::memory_order_relaxed);
  const std::int64_t now_ns = monotonic_ns();
  announce();
  if (doubt == Doubt::none) {
    if (now_ns - doubted_ns_ >= kRecoveredNs) policy_.reset();
    inbox_.forget();
    progress_.set({});
  } else {
    doubted_ns_ = now_ns;
  }
  if (doubt == Doubt::none || now_ns < next_check_ns_) {
    std::this_thread::sleep_for(kTurn);
    return false;
  }
  const FrameCopy* const frame = inbox_.next(kFramePatience);
  if (frame == nullptr) return false;
  const SensorView view = keeper_.snapshot();
  const SensorSnapshot& sensor = *view;
  if (frame->plan_id != sensor.plan_id) return false;  // the sensor has changed since
  if (frame->plan_id == replaced_plan_id_ && now_ns - replaced_ns_ < kAdoptPatienceNs) return false;
  return search_if_due(*frame, sensor, doubt);
}

/// Searches the frame if a search is due.
bool SpotSearch::search_if_due(const FrameCopy& frame, const SensorSnapshot& sensor, Doubt doubt) {
  const SpotModel spots = spot_model(sensor.sensor, sensor.optics, slm_, frame.image.format);
  const int bin = std::max(1, int(kCell * spots.on_plane().lambda_d_px));
  BinnedImage image = binned(frame.image, spots.lit.plane, bin);
  const bool changed = !searched_ || is_other_image(*searched_, image);
  if (!policy_.is_due(doubt, changed, monotonic_ns())) {
    next_check_ns_ = monotonic_ns() + kCheckPauseNs;
    return false;
  }
  policy_.begin(changed);
  searched_ = std::move(image);
  progress_.change([](SearchProgress& now) { now.running = true; });
  std::optional<SplitSpots> found = search(frame, sensor);
  if (found) found_ns_.store(monotonic_ns(), std::memory_order_relaxed);
  // A failed search changes nothing while frames are valid: the current plan still works.
  if (found || doubt == Doubt::blind) {
    if (found && is_tracked_already(*found, frame, sensor, spots.lambda_d_px)) found.reset();
    const bool changes = found || !sensor.split.empty();
    if (changes) replaced_plan_id_ = sensor.plan_id, replaced_ns_ = monotonic_ns();
    keeper_.track_split_spots(sensor.plan_id, std::move(found));
  }
  policy_.end(monotonic_ns());
  progress_.change([&](SearchProgress& now) {
    now = {false, now.searches + 1, policy_.next_ns()};
  });
  return true;
}

std::optional<SplitSpots> SpotSearch::search(const FrameCopy& frame, const SensorSnapshot& sensor) {
  try {
    return make_bench(frame, sensor) ? explain(frame) : std::nullopt;
  } catch (const std::bad_alloc&) {
    bench_.reset();  // the ordinary plan does not need it
    return std::nullopt;
  }
}

/// Tries the plain tracker first: it suffices once a strong aberration is gone.
std::optional<SplitSpots> SpotSearch::explain(const FrameCopy& frame) {
  const std::size_t count = bench_->reference_px.size();
  std::vector<SpotFix> fixes(count);
  ShapedAcquisition& acquisition = bench_->acquisition;
  const std::vector<Vec2> tracked_px = positions(frame.spots);
  acquisition.acquire(frame.image, *bench_->tracker, bench_->scratch, fixes, true, tracked_px);
  if (acquisition.shapes().empty()) {
    if (is_explained_plain(fixes)) return SplitSpots{positions(fixes), {}};
    acquisition.acquire(frame.image, *bench_->tracker, bench_->scratch, fixes, false, tracked_px);
  }
  if (acquisition.shapes().empty()) return std::nullopt;
  SplitSpots out;
  for (const ShapedSpot& spot : acquisition.shapes()) out.at_px.push_back(spot.at_px);
  const std::vector<bool>& split = acquisition.split();
  if (std::none_of(split.begin(), split.end(), [](bool one) { return one; })) return out;
  out.templates =
      shape_templates(bench_->optics, bench_->spots.on_plane(), acquisition.waves(), split);
  return out;
}

/// Whether all spots that have a reference are found and a wavefront explains their positions.
bool SpotSearch::is_explained_plain(std::span<const SpotFix> fixes) const {
  const Reconstructor& plain = bench_->plain;
  Reconstructor::Scratch scratch = plain.make_scratch();
  std::vector<float> coefficients(plain.modes_j().size());
  const Reconstruction found = plain.solve(fixes, scratch, coefficients);
  return found.determined && found.lost == 0 &&
         found.fit_residual_px <= kMaxResidual * bench_->spots.lambda_d_px;
}

/// Prepares the search. False: the sensor in the snapshot cannot be modelled, or is too large.
bool SpotSearch::make_bench(const FrameCopy& frame, const SensorSnapshot& sensor) {
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
                    bench_->px_per_cycle == map && bench_->spots == spots &&
                    bench_->plain.modes_j() == sensor.position_modes_j;
  if (same) return true;
  bench_.reset();
  if (reference_px.size() > kMaxSpots || spots.lambda_d_px > kMaxSpotPx) return false;
  auto tracker = make_tracker(sensor.tracking, spots);
  if (!tracker) return false;
  const Eigen::MatrixXd slopes =
      slope_matrix(*lattice, sensor.sensor, sensor.position_modes_j,
                   slope_model(sensor.sensor.charge, sensor.tracking), map);
  TrackScratch scratch = (*tracker)->make_scratch();
  bench_ = std::make_unique<Bench>(
      Bench{sensor.sensor, sensor.tracking, cols, rows, map, reference_px, std::move(*tracker),
            std::move(scratch), spots,
            ShapedAcquisition(*lattice, sensor.sensor, spots, map, sensor.position_modes_j, slopes,
                              reference_px, cols, rows),
            template_optics(*lattice, sensor.sensor, sensor.position_modes_j,
                            map / spots.lit.plane.step, spots.on_plane()),
            Reconstructor(slopes, sensor.position_modes_j,
                          sensor.reference ? known_positions(*sensor.reference) : reference_px,
                          rotation_column(*lattice, sensor.sensor, map, sensor.reference.get()))});
  return true;
}

}  // namespace ovws
