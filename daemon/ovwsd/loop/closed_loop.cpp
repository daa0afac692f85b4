#include "daemon/ovwsd/loop/closed_loop.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <utility>

#include "core/control/loop_laws.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/loop/step_due.hpp"

namespace ovws {
namespace {

constexpr int kTurnMs = 50;
constexpr std::chrono::microseconds kNow(0);
constexpr std::int64_t kInvalidNs = 300'000'000;
// A step that is late misses its refresh: it allows for the second longest of 32 preparations.
constexpr double kSafeShare = 0.95;
constexpr std::int64_t kSpareNs = 500'000;
constexpr int kMinSpotsPerLost = 3;
constexpr double kMaxResidual = 0.06;  // lambda/d

/// `no_frame`: why no usable frame came.
std::string reason_of(LoopEnd end, const LoopSettings& settings, const std::string& no_frame) {
  switch (end) {
    case LoopEnd::none:
      break;
    case LoopEnd::too_few_spots:
      return fmt::format("no usable frame came for {:g} s: {}", settings.patience_s, no_frame);
    case LoopEnd::at_limit:
      return fmt::format(
          "the correction was at its limit of {:g} waves for {:g} s: reduce the aberration, "
          "or close the loop with a higher limit_waves",
          settings.limit_waves, settings.patience_s);
    case LoopEnd::growing:
      return fmt::format(
          "the residual was {:g} times its previous level for {:g} s: close the loop with a "
          "lower gain, or run calibration.run",
          settings.growth, settings.patience_s);
  }
  return "";
}

/// Checks the modes of one list of the settings: each is measured, and none is there twice.
Result<void> check_listed(std::string_view field, std::vector<int> listed,
                          const std::vector<int>& measured) {
  std::ranges::sort(listed);
  if (const auto twice = std::ranges::adjacent_find(listed); twice != listed.end()) {
    return fail(Errc::invalid, std::string(field),
                fmt::format("mode j = {} is given twice", *twice));
  }
  for (const int j : listed) {
    if (std::ranges::find(measured, j) != measured.end()) continue;
    return fail(Errc::invalid, std::string(field),
                fmt::format("mode j = {} is not among the modes j = {} to {} that can be corrected",
                            j, measured.front(), measured.back()));
  }
  return {};
}

Result<void> check_modes(const LoopSettings& settings, const std::vector<int>& measured) {
  const auto modes_of = [](const auto& list) {
    std::vector<int> modes;
    for (const auto& mode : list) modes.push_back(mode.j);
    return modes;
  };
  if (auto good = check_listed("modes", settings.modes, measured); !good) return good;
  if (auto good = check_listed("gains", modes_of(settings.gains), measured); !good) return good;
  return check_listed("offsets", modes_of(settings.offsets),
                      settings.modes.empty() ? measured : settings.modes);
}

/// Preconditions for closing the loop: the sensor's hologram is shown, there is a reference, each
/// mode to correct is measured, and the present correction is within the limit.
Result<void> check_against(const LoopSettings& settings, const SensorSnapshot& sensor) {
  if (auto shown = check_shows_one_sensor(sensor); !shown) return shown;
  if (!sensor.reference) {
    return fail(Errc::refused, "reference",
                "there is no reference for the loop: take one with reference.take first");
  }
  if (auto known = check_modes(settings, sensor.modes_j); !known) return known;
  for (const Mode& mode : sensor.correction) {
    if (std::abs(mode.waves) <= settings.limit_waves) continue;
    return fail(Errc::refused, "limit_waves",
                fmt::format("the correction holds {:.3f} waves of mode j = {}, more than the limit "
                            "of {:g}: raise limit_waves, or call correction.clear first",
                            mode.waves, mode.j, settings.limit_waves));
  }
  return {};
}

/// Whether an invalid frame may still steer the loop: it is settled, has a reference and no branch
/// point, at most one spot in every kMinSpotsPerLost is lost, and the fit residual is at most
/// kMaxResidual.
bool is_rough_guide(const FrameRecord& record) {
  const Reconstruction& found = record.reconstruction;
  return record.settled && record.plan->referenced() && record.branch_points.count == 0 &&
         found.determined && kMinSpotsPerLost * found.lost <= found.used + found.lost &&
         found.fit_residual_px <= kMaxResidual * record.plan->spots.lambda_d_px;
}

}  // namespace

/// The sensor is as the check saw it until the loop has begun, because the lease is the loop's.
void ClosedLoop::close(LeasePtr lease, const LoopSettings& settings, Done done) {
  Lease& taken = *lease;
  taken.begin(
      [this, lease = std::move(lease), settings, counted = closing(), done = std::move(done)] {
        const auto known = model();
        const auto sensor = checked(settings, known.get());
        if (!sensor) {
          lease->end();
          return done(fail(sensor.error()));
        }
        mailbox_.post([this, lease, settings, known, sensor = *sensor, counted, done] {
          done(begin(lease, settings, known, *sensor));
        });
      });
}

/// Counts a `close` until its last step has ended or is dropped, and lets the tasks go on that
/// wait.
std::shared_ptr<void> ClosedLoop::closing() {
  const std::lock_guard lock(order_->mutex);
  ++order_->closing;
  return {nullptr, [this, order = order_](void*) {
            const std::lock_guard ended(order->mutex);
            if (--order->closing > 0 || order->is_over) return;
            for (auto& task : std::exchange(order->waiting, {})) mailbox_.post(std::move(task));
          }};
}

/// A `close` that was requested before may still wait for changes under way: `task` comes after it.
void ClosedLoop::post_after_closing(std::function<void()> task) {
  const std::lock_guard lock(order_->mutex);
  if (order_->closing > 0) return order_->waiting.push_back(std::move(task));
  mailbox_.post(std::move(task));
}

void ClosedLoop::open(bool keep, Done done) {
  post_after_closing([this, keep, done = std::move(done)] { done(end(keep)); });
}

ClosedLoop::~ClosedLoop() {
  const std::lock_guard lock(order_->mutex);
  order_->is_over = true;  // steps of a `close` may be dropped later
}

void ClosedLoop::pause(bool paused, Done done) {
  post_after_closing([this, paused, done = std::move(done)] { done(set_paused(paused)); });
}

/// Publish thread: whether the loop observes a frame.
bool ClosedLoop::is_usable(const FrameRecord& record) {
  const std::int64_t now_ns = monotonic_ns();
  if (record.valid) valid_ns_ = now_ns;
  if (!record.valid && (now_ns - valid_ns_ < kInvalidNs || !is_rough_guide(record))) return false;
  return is_of_own_hologram(record);
}

bool ClosedLoop::do_work() {
  const bool asked = mailbox_.run_one(std::chrono::milliseconds(is_closed() ? 0 : kTurnMs));
  if (!is_closed()) return asked;
  notice_bench();
  if (observe_next() || paused_ || !is_closed()) return true;
  const LoopEnd end = watch_->wait(monotonic_ns(), deps_.spots_found_ns());
  if (end != LoopEnd::none) open_because(end);
  return asked;
}

void ClosedLoop::open_because(LoopEnd end) {
  set_closed(false, reason_of(end, report_.get().settings, why_no_frame()), Severity::warning);
}

/// The SLM's cause first: frames of another hologram may be valid.
std::string ClosedLoop::why_no_frame() const {
  const SlmSnapshot slm = deps_.slm.snapshot();
  if (slm.hologram_id != deps_.keeper.snapshot()->hologram_id) {
    return "the SLM does not show the loop's hologram; see slm in ovws status";
  }
  const std::string why = deps_.why_invalid();
  return why.empty() ? "the camera sends no settled frame; see camera in ovws status" : why;
}

/// While the camera or the display is away, the watch begins again and again. Afterwards only new
/// frames count, and the step over that time tells no times.
void ClosedLoop::notice_bench() {
  const bool away = !deps_.leases.has_bench();
  if (away) watch_.emplace(report_.get().settings, monotonic_ns());
  if (std::exchange(away_, away) == away) return;
  stepped_ = true;
  shown_id_ = 0;
  while (frames_->next(taken_, kNow)) {
  }
  deps_.events.emit(
      "loop", away ? Severity::warning : Severity::info,
      away ? "the loop holds its correction: the camera or the display is not connected"
           : "the camera and the display are connected again",
      {{"closed", true},
       {"holds", away},
       {"paused", paused_.load()},
       {"steps", report_.get().steps}});
}

/// Observes the next frame if one comes in time, and steps if it is time. False: there was no step,
/// and no frame of the newest hologram. The error of an older one may have been corrected.
bool ClosedLoop::observe_next() {
  const std::int64_t due_ns = stepped_ || paused_ ? StepState::kNever : t_step_due_ns();
  const std::chrono::nanoseconds left(
      std::clamp(due_ns - monotonic_ns(), std::int64_t{0}, kTurnMs * std::int64_t{1'000'000}));
  const bool came =
      frames_->next(taken_, std::chrono::duration_cast<std::chrono::microseconds>(left));
  if (came) observe(taken_);
  const bool newest = taken_.hologram_id == deps_.keeper.snapshot()->hologram_id;
  // A frame that comes when a step is due does not postpone it.
  if (stepped_ || paused_ || monotonic_ns() < std::min(due_ns, t_step_due_ns())) {
    return came && newest;
  }
  step(taken_);
  return true;
}

std::int64_t ClosedLoop::t_step_due_ns() const {
  const SlmSnapshot slm = deps_.slm.snapshot();
  if (slm.hologram_id != deps_.keeper.snapshot()->hologram_id) return StepState::kNever;
  StepState state{.t_observed_ns = t_observed_ns_,
                  .has_newest = taken_.hologram_id == slm.hologram_id,
                  .usual_prepare_ns = prepare_.ns(0.5),
                  .safe_prepare_ns = prepare_.ns(kSafeShare) + kSpareNs};
  if (taken_.period_ns > 0) {
    state.t_exposed_ns = slm.t_settled_mono_ns + taken_.period_ns + taken_.transfer_ns +
                         taken_.t_exposed_mono_ns - taken_.t_begin_ns();
  }
  if (slm.t_refresh_mono_ns > 0 && slm.info) {
    state.t_refresh_ns = slm.t_refresh_mono_ns;
    state.refresh_ns = std::llround(1e9 / slm.info->refresh_hz);
  }
  return t_due_ns(state);
}

void ClosedLoop::observe(const FrameCopy& frame) {
  t_observed_ns_ = monotonic_ns();
  control_->observe({frame.t_middle_ns(), frame.measured(frame.modes_j),
                     frame.measured(frame.coefficients), frame.measured(frame.sigma_waves)},
                    frame.shown());
  log_.observed(frame.frame.frame_id, frame.t_middle_ns());
  stepped_ = false;
}

LoopReport ClosedLoop::begin(const LeasePtr& lease, const LoopSettings& settings,
                             const std::shared_ptr<const LoopModel>& known,
                             const SensorSnapshot& sensor) {
  control_.emplace(settings, sensor.correction, laws_of(settings, known));
  watch_.emplace(settings, monotonic_ns());
  log_.closed(settings, sensor.correction, known.get());
  times_ = {};
  stepped_ = true;
  shown_id_ = 0;
  paused_ = away_ = false;
  lead_ = prepare_ = {};
  valid_ns_ = monotonic_ns();
  frames_.emplace(deps_.frames, kFrames,
                  [this](const FrameRecord& record) { return is_usable(record); });
  LoopReport report;
  report.settings = settings;
  report_.set(report);
  lease_ = lease;  // last: a step that throws leaves it to its caller
  set_closed(true, "", Severity::info);
  return this->report();
}

/// The present sensor, if the loop can be closed with these settings.
Result<SensorView> ClosedLoop::checked(const LoopSettings& settings, const LoopModel* model) const {
  SensorView sensor = deps_.keeper.snapshot();
  if (auto good = check_against(settings, *sensor); !good) return fail(good.error());
  if (auto known = check_model(settings, model, sensor->modes_j); !known) {
    return fail(known.error());
  }
  return sensor;
}

Result<LoopReport> ClosedLoop::end(bool keep) {
  LeasePtr lease;
  if (!keep && !is_closed()) {
    auto taken = deps_.leases.take(Request::set_correction);
    if (!taken) return fail(taken.error());
    lease = std::move(*taken);
  }
  if (!keep) {
    if (auto cleared = show({}); !cleared) return fail(cleared.error());
  }
  if (is_closed()) set_closed(false, LoopReport::kOpenedOnRequest, Severity::info);
  return this->report();
}

/// After a pause a new watch begins: what happened meanwhile does not count.
Result<LoopReport> ClosedLoop::set_paused(bool paused) {
  if (!is_closed()) return fail(Errc::refused, "", "the loop is open: call loop.close first");
  LoopReport report = report_.get();
  if (paused_ && !paused) {
    watch_.emplace(report.settings, monotonic_ns());
    shown_id_ = 0;  // a step over the pause tells no times
  }
  const bool changes = paused_ != paused;
  paused_ = report.paused = paused;
  report_.set(report);
  if (changes) {
    deps_.events.emit("loop", Severity::info, paused ? "the loop is paused" : "the loop goes on",
                      {{"closed", true}, {"paused", paused}, {"steps", report.steps}});
  }
  return this->report();
}

LoopReport ClosedLoop::report() const {
  LoopReport report = report_.get();
  report.correction_rms_waves = rms_waves(deps_.keeper.snapshot()->correction);
  return report;
}

void ClosedLoop::step(const FrameCopy& frame) {
  const SlmSnapshot before = deps_.slm.snapshot();
  const std::int64_t decided_ns = monotonic_ns();
  stepped_ = true;
  const std::int64_t t_for_ns = decided_ns + lead_.ns(0.5);
  control_->step(t_for_ns);
  const LoopEnd end =
      watch_->step(control_->residual_rms_waves(), control_->at_limit(), decided_ns);
  if (end != LoopEnd::none) return open_because(end);
  if (auto shown = show(control_->correction()); !shown) {
    log_.decided(t_for_ns, 0);
    if (!deps_.leases.has_bench()) return;
    return set_closed(false, "the correction cannot be shown: " + shown.error().reason,
                      Severity::warning);
  }
  const std::uint64_t shown_id = deps_.keeper.snapshot()->hologram_id;
  log_.decided(t_for_ns, shown_id);
  if (std::exchange(shown_id_, shown_id) == before.hologram_id) {
    add_times(frame, decided_ns, before);
  }
  report_step();
}

/// Records where the step's time went, and its delay. `before`: the SLM when the step was decided.
void ClosedLoop::add_times(const FrameCopy& frame, std::int64_t decided_ns,
                           const SlmSnapshot& before) {
  const SlmSnapshot now = deps_.slm.snapshot();
  if (now.t_presented_mono_ns < decided_ns) return;  // the same hologram
  const auto ms = [](std::int64_t from_ns, std::int64_t to_ns) {
    return 1e-6 * double(to_ns - from_ns);
  };
  StepTimes times;
  times.settle_ms = ms(before.t_presented_mono_ns, before.t_settled_mono_ns);
  const bool newest = frame.hologram_id == before.hologram_id;
  const std::int64_t known_ns = std::max(t_observed_ns_, before.t_settled_mono_ns);
  if (newest) {
    times.wait_ms = ms(before.t_settled_mono_ns, frame.t_begin_ns());
    times.exposure_ms = ms(frame.t_begin_ns(), frame.t_exposed_mono_ns);
    times.compute_ms = ms(frame.t_exposed_mono_ns, known_ns);
  } else {
    times.wait_ms = ms(before.t_settled_mono_ns, known_ns);
  }
  const std::int64_t ready_ns = now.t_begin_mono_ns - now.refresh_wait_ns;
  times.render_ms = ms(decided_ns, ready_ns);
  times.refresh_ms = ms(known_ns, decided_ns) + ms(ready_ns, now.t_begin_mono_ns);
  times.present_ms = ms(now.t_begin_mono_ns, now.t_presented_mono_ns);
  // A hologram is shown about half a settle time later than it is presented, as is the next one.
  const std::int64_t period_ns = now.t_presented_mono_ns - before.t_presented_mono_ns;
  const std::int64_t settle_ns = before.t_settled_mono_ns - before.t_presented_mono_ns;
  const std::int64_t shown_ns = now.t_presented_mono_ns + (period_ns + settle_ns) / 2;
  lead_.add(shown_ns - decided_ns);
  prepare_.add(ready_ns - decided_ns);
  times_.add({times, ms(frame.t_middle_ns(), shown_ns), newest});
}

/// Blocks until the prepare thread has shown it.
Result<void> ClosedLoop::show(const std::vector<Mode>& correction) {
  auto promise = std::make_shared<std::promise<Result<void>>>();
  auto answer = promise->get_future();
  deps_.keeper.edit(set_correction(correction),
                    [promise = std::move(promise)](const Result<SensorView>& now) {
                      promise->set_value(now ? Result<void>{} : fail(now.error()));
                    });
  try {
    return answer.get();
  } catch (const std::future_error&) {  // the prepare thread has ended
    return fail(Errc::unavailable, "", "the daemon is stopping");
  }
}

void ClosedLoop::set_closed(bool closed, const std::string& why, Severity severity) {
  LoopReport report = report_.get();
  report.closed = closed;
  report.paused = paused_ = false;
  report.opened_because = why;
  report.t_opened_ns = utc_ns();
  if (!closed) log_.opened();
  if (!closed) frames_.reset();
  // Before the report: a client that reads of an open loop may close it at once.
  if (const auto lease = closed ? nullptr : std::exchange(lease_, nullptr)) lease->end();
  closed_ = closed;
  report_.set(report);
  deps_.events.emit("loop", severity, closed ? "the loop is closed" : "the loop is open: " + why,
                    {{"closed", closed}, {"steps", report.steps}});
}

void ClosedLoop::report_step() {
  LoopReport report = report_.get();
  report.steps = control_->steps();
  report.residual_rms_waves = control_->residual_rms_waves();
  constexpr std::int64_t kSummarise = 16;  // steps: a summary sorts all durations
  if (report.steps % kSummarise == 0) report.step = times_.summary();
  report_.set(report);
}

}  // namespace ovws
