#include "daemon/ovwsd/loop/closed_loop.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <utility>

#include "core/control/integrator.hpp"
#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kTurn(50);
constexpr std::int64_t kInvalidNs = 300'000'000;
constexpr int kMinSpotsPerLost = 3;
constexpr double kMaxResidual = 0.06;  // lambda/d

std::string reason_of(LoopEnd end, const LoopSettings& settings) {
  switch (end) {
    case LoopEnd::none:
      break;
    case LoopEnd::too_few_spots:
      return fmt::format(
          "no usable frame came for {:g} s: too few spots are tracked, or the camera "
          "or the SLM is at fault; see ovws status",
          settings.patience_s);
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

/// Preconditions for closing the loop: the sensor's hologram is shown, there is a reference, each
/// mode to correct is measured, and the present correction is within the limit.
Result<void> check_against(const LoopSettings& settings, const SensorSnapshot& sensor) {
  if (auto shown = check_shows_sensor(sensor); !shown) return shown;
  if (!sensor.reference) {
    return fail(Errc::refused, "reference",
                "there is no reference for the loop: take one with reference.take first");
  }
  for (const int j : settings.modes) {
    const auto& measured = sensor.modes_j;
    if (std::find(measured.begin(), measured.end(), j) != measured.end()) continue;
    return fail(Errc::invalid, "modes",
                fmt::format("mode j = {} is not measured: this sensor measures j = {} to {}", j,
                            measured.front(), measured.back()));
  }
  for (const Mode& mode : sensor.correction) {
    if (std::abs(mode.waves) <= settings.limit_waves) continue;
    return fail(Errc::refused, "limit_waves",
                fmt::format("the correction holds {:.3f} waves of mode j = {}, more than the limit "
                            "of {:g}: raise limit_waves, or call correction.clear first",
                            mode.waves, mode.j, settings.limit_waves));
  }
  return {};
}

/// Makes the integrator of a mode, with its own gain if it has one.
ModalControl::MakeLaw integrators(const LoopSettings& settings) {
  return [settings](int j, double correction_waves) {
    const auto own = std::ranges::find(settings.gains, j, &ModeGain::j);
    const double gain = own != settings.gains.end() ? own->gain : settings.gain;
    return std::make_unique<Integrator>(gain, settings.leak, correction_waves);
  };
}

/// Whether an invalid frame may still steer the loop: it is settled and has a reference, at most
/// one spot in every kMinSpotsPerLost is lost, and the fit residual is at most kMaxResidual.
bool is_rough_guide(const FrameRecord& record) {
  const Reconstruction& found = record.reconstruction;
  return record.settled && record.plan->referenced() && found.determined &&
         kMinSpotsPerLost * found.lost <= found.used + found.lost &&
         found.fit_residual_px <= kMaxResidual * record.plan->spots.lambda_d_px;
}

}  // namespace

void ClosedLoop::close(const LoopSettings& settings, Done done) {
  mailbox_.post([this, settings, done = std::move(done)] { done(begin(settings)); });
}

void ClosedLoop::open(bool keep, Done done) {
  mailbox_.post([this, keep, done = std::move(done)] { done(end(keep)); });
}

void ClosedLoop::add(const FrameRecord& record) {
  const std::int64_t now_ns = monotonic_ns();
  if (record.valid || !is_closed()) valid_ns_ = now_ns;
  if (!is_closed()) return;
  if (!record.valid && (now_ns - valid_ns_ < kInvalidNs || !is_rough_guide(record))) return;
  {
    const std::lock_guard lock(mutex_);
    newest_.hologram_id = record.hologram_id;
    // Spot positions, unlike templates, measure only the leading modes of the plan.
    newest_.modes_j =
        record.templates.credible ? record.plan->modes_j : record.plan->reconstructor->modes_j();
    const auto modes = std::ptrdiff_t(newest_.modes_j.size());
    newest_.residual_waves.assign(record.coefficients.begin(), record.coefficients.begin() + modes);
    newest_.sigma_waves.assign(record.sigma_waves.begin(), record.sigma_waves.begin() + modes);
    newest_.t_ns = record.frame.t_arrival_mono_ns - std::llround(500.0 * record.exposure_us);
    has_sample_ = true;
  }
  filled_.notify_one();
}

bool ClosedLoop::do_work() {
  const bool asked = mailbox_.run_one(is_closed() ? std::chrono::milliseconds(0) : kTurn);
  if (!is_closed()) return asked;
  if (const SensorView sensor = take_sample()) {
    act(*sensor);
    return true;
  }
  const LoopEnd end = watch_->wait(monotonic_ns(), deps_.spots_found_ns());
  if (end != LoopEnd::none)
    set_closed(false, reason_of(end, report_.get().settings), Severity::warning);
  return asked;
}

/// Waits for a sample, for kTurn at most, and returns the sensor that it was measured with. Null if
/// no sample came, or if it was measured with an older hologram: a later step has corrected that
/// error already.
SensorView ClosedLoop::take_sample() {
  std::unique_lock lock(mutex_);
  if (!filled_.wait_for(lock, kTurn, [this] { return has_sample_; })) return nullptr;
  std::swap(taken_, newest_);
  has_sample_ = false;
  lock.unlock();
  SensorView sensor = deps_.keeper.snapshot();
  return taken_.hologram_id == sensor->hologram_id ? sensor : nullptr;
}

Result<LoopReport> ClosedLoop::begin(const LoopSettings& settings) {
  if (is_closed())
    return fail(Errc::refused, "", "the loop is already closed: call loop.open first");
  const auto held = ask([&](SensorKeeper::Done done) {
    deps_.keeper.after_changes([this, settings, done = std::move(done)] { done(hold(settings)); });
  });
  if (!held) return fail(held.error());
  const SensorSnapshot& sensor = **held;
  control_.emplace(settings, sensor.correction, integrators(settings));
  watch_.emplace(settings, monotonic_ns());
  LoopReport report;
  report.settings = settings;
  report_.set(report);
  {
    const std::lock_guard lock(mutex_);
    has_sample_ = false;  // an earlier sample may refer to another reference
  }
  set_closed(true, "", Severity::info);
  return this->report();
}

/// Runs in the prepare thread: checks the settings against the present sensor, then holds the
/// sensor for the loop.
Result<SensorView> ClosedLoop::hold(const LoopSettings& settings) {
  if (auto free = deps_.keeper.may_hold(); !free) return fail(free.error());
  SensorView sensor = deps_.keeper.snapshot();
  if (auto good = check_against(settings, *sensor); !good) return fail(good.error());
  deps_.keeper.hold(Hold::of_loop());
  return sensor;
}

Result<LoopReport> ClosedLoop::end(bool keep) {
  if (!keep) {
    if (auto cleared = show({}); !cleared) return fail(cleared.error());
  }
  if (is_closed()) set_closed(false, "loop.open was called", Severity::info);
  return this->report();
}

LoopReport ClosedLoop::report() const {
  LoopReport report = report_.get();
  report.correction_rms_waves = rms_waves(deps_.keeper.snapshot()->correction);
  return report;
}

void ClosedLoop::act(const SensorSnapshot& sensor) {
  const std::int64_t now_ns = monotonic_ns();
  control_->observe({taken_.t_ns, taken_.modes_j, taken_.residual_waves, taken_.sigma_waves},
                    sensor.correction);
  control_->step(now_ns);
  const LoopEnd end = watch_->step(control_->residual_rms_waves(), control_->at_limit(), now_ns);
  if (end != LoopEnd::none)
    return set_closed(false, reason_of(end, report_.get().settings), Severity::warning);
  if (auto shown = show(control_->correction()); !shown) {
    return set_closed(false, "the correction cannot be shown: " + shown.error().reason,
                      Severity::warning);
  }
  report_step();
}

Result<void> ClosedLoop::show(const std::vector<Mode>& correction) {
  const auto shown = ask([&](SensorKeeper::Done done) {
    deps_.keeper.edit(Hold::of_loop(), set_correction(correction), std::move(done));
  });
  if (!shown) return fail(shown.error());
  return {};
}

/// Sends a request to the prepare thread, and blocks until the thread has answered.
Result<SensorView> ClosedLoop::ask(const std::function<void(SensorKeeper::Done)>& what) {
  auto promise = std::make_shared<std::promise<Result<SensorView>>>();
  auto answer = promise->get_future();
  what([promise = std::move(promise)](Result<SensorView> now) {
    promise->set_value(std::move(now));
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
  report.opened_because = why;
  report.t_opened_ns = utc_ns();
  report_.set(report);
  closed_ = closed;
  if (!closed) deps_.keeper.release(Hold::of_loop(), [] {});
  deps_.on_change(closed);
  deps_.events.emit("loop", severity, closed ? "the loop is closed" : "the loop is open: " + why,
                    {{"closed", closed}, {"steps", report.steps}});
}

void ClosedLoop::report_step() {
  LoopReport report = report_.get();
  report.steps = control_->steps();
  report.residual_rms_waves = control_->residual_rms_waves();
  report_.set(report);
}

}  // namespace ovws
