#include "daemon/ovwsd/fitter/live_refiner.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <thread>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kTurn(50);
constexpr std::int64_t kReportAfterNs = 2'000'000'000;  // then status reports a missing frame

/// Adapts the error of a black level that contradicts the saturation: it names the setting that the
/// client has changed.
Error of_given(Error error, const RefineSet& change, const RefineSetup& next) {
  const bool black_stands =
      error.field == "black_level_dn" && !change.gives(&RefineSetup::black_level_dn);
  if (!black_stands || !change.gives(&RefineSetup::saturation_dn)) return error;
  error.field = "saturation_dn";
  error.reason = fmt::format("must be above black_level_dn, which is {}", next.black_level_dn);
  return error;
}

}  // namespace

LiveRefiner::LiveRefiner(const RefineSetup& settings, const OpticsConfig& optics,
                         const SlmGeometry& slm, FrameTaps& frames, const SensorKeeper& keeper,
                         StreamQueue& queue)
    : wavelength_nm_(optics.wavelength_nm),
      keeper_(keeper),
      queue_(queue),
      model_(slm),
      inbox_(frames, can_be_refined),
      settings_(settings) {
  set_state("waiting", std::nullopt);
}

bool LiveRefiner::do_work() {
  const RefineSetup settings = settings_.get();
  if (!settings.enabled || ending_) {
    inbox_.forget();
    waiting_since_ns_ = 0;
    set_state("waiting", std::nullopt);
    std::this_thread::sleep_for(kTurn);
    return false;
  }
  const std::int64_t period_ns = std::int64_t(1e9 / settings.rate_hz);
  const std::int64_t left_ns = last_due_ns_ + period_ns - monotonic_ns();
  if (last_due_ns_ != 0 && left_ns > 0) {
    std::this_thread::sleep_for(
        std::min(std::chrono::nanoseconds(left_ns), std::chrono::nanoseconds(kTurn)));
    return false;
  }
  const auto frame = inbox_.next(kTurn);
  if (!frame) {
    wait_for_frame();
    return false;
  }
  waiting_since_ns_ = 0;
  const SensorView view = keeper_.snapshot();
  const SensorSnapshot& sensor = *view;
  if (frame->plan_id != sensor.plan_id) return false;  // the sensor has changed since this frame
  // The wait for a frame must not lower the mean rate.
  last_due_ns_ = std::max(last_due_ns_ + period_ns, monotonic_ns() - period_ns);
  refine(*frame, sensor, settings);
  return true;
}

void LiveRefiner::wait_for_frame() {
  const std::int64_t now_ns = monotonic_ns();
  if (waiting_since_ns_ == 0) waiting_since_ns_ = now_ns;
  if (now_ns - waiting_since_ns_ < kReportAfterNs) return;
  set_state("waiting",
            "no settled and valid frame has arrived: system.status says why frames are not valid");
}

void LiveRefiner::refine(const FrameCopy& frame, const SensorSnapshot& sensor,
                         const RefineSetup& settings) {
  set_state("refining", report_.get().reason);
  RefinedFrame refined;
  try {
    refined = model_.refine(frame, sensor, settings);
  } catch (const std::bad_alloc&) {
    refined.refusal =
        "there is not enough memory for a model of this SLM and this image: reduce camera.roi";
  }
  const RefineSetup now = settings_.get();
  if (!now.enabled || !same_fit(now, settings)) return set_state("waiting", std::nullopt);
  report_.change([&refined](StatusMessage::RefinePart& report) {
    ++(refined.refusal.empty() ? report.done : report.refused);
    if (refined.duration_ms > 0.0) report.last_duration_ms = refined.duration_ms;
    report.state = "waiting";
    report.reason =
        refined.refusal.empty() ? std::nullopt : std::optional<std::string>(refined.refusal);
  });
  publish(frame, sensor, std::move(refined));
}

void LiveRefiner::publish(const FrameCopy& frame, const SensorSnapshot& sensor,
                          RefinedFrame refined) {
  RefinedMessage message;
  message.frame_id = frame.frame.frame_id;
  message.hologram_id = frame.hologram_id;
  message.t_arrival_ns = frame.frame.t_arrival_ns;
  message.charge = frame.charge;
  message.valid = refined.refusal.empty();
  message.reason = std::move(refined.refusal);
  message.against_reference = refined.against_reference;
  message.wavelength_nm = wavelength_nm_;
  message.gain_db = frame.gain_db;
  message.gain_raw = frame.gain_raw;
  message.exposure_us = frame.exposure_us;
  message.j = sensor.modes_j;
  message.duration_ms = refined.duration_ms;
  if (refined.modes) {
    RefinedModes& modes = *refined.modes;
    message.coefficients = std::move(modes.waves);
    message.sigma = std::move(modes.sigma_waves);
    message.fit = RefinedMessage::Fit{modes.chi2_per_pixel, modes.peak_e, modes.background_e,
                                      modes.iterations};
  }
  queue_.put(std::move(message));
}

void LiveRefiner::set_state(std::string state, std::optional<std::string> reason) {
  report_.change([&](StatusMessage::RefinePart& report) {
    report.state = std::move(state);
    report.reason = std::move(reason);
  });
}

StatusMessage::RefinePart LiveRefiner::report() const {
  StatusMessage::RefinePart report = report_.get();
  if (!settings_.get().enabled) {
    report.state = "off";
    report.reason.reset();
  }
  return report;
}

Result<RefineSetup> LiveRefiner::change(const RefineSet& change, PixelFormat format) {
  auto changed = settings_.change([&](RefineSetup& settings) -> Result<RefineSetup> {
    RefineSetup next = change.applied_to(in_format(settings, format));
    if (change.clamp() && next.saturation_dn) {
      next.saturation_dn = std::min(*next.saturation_dn, full_scale_dn(next.format));
    }
    if (auto whole = check_refine(next); !whole) return fail(of_given(whole.error(), change, next));
    settings = next;
    return next;
  });
  if (changed) queue_.request_status();
  return changed;
}

}  // namespace ovws
