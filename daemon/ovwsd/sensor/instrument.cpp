#include "daemon/ovwsd/sensor/instrument.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/ovwsd/sensor/spot_layout.hpp"
#include "daemon/shared/slm_files.hpp"

namespace ovws {
namespace {

constexpr auto kTurn = std::chrono::milliseconds(50);

Result<std::shared_ptr<const HologramRenderer>> make_renderer(const HologramConfig& hologram) {
  auto renderer = HologramRenderer::make(hologram);
  if (!renderer) return fail(renderer.error());
  return std::make_shared<const HologramRenderer>(std::move(*renderer));
}

}  // namespace

Result<std::unique_ptr<Instrument>> Instrument::make(const Config& config,
                                                     const InstrumentDeps& deps) {
  auto hologram = load_hologram_config(config);
  if (!hologram) return fail(hologram.error());
  State state;
  state.sensor = config.sensor;
  state.tracking = config.tracking;
  state.roi = config.camera.settings.roi;
  state.format = config.camera.settings.pixel_format;
  std::unique_ptr<Instrument> instrument(new Instrument(config, deps, *hologram, state));
  SlmArchive& slm = instrument->slm_archive_;
  state.slm = slm_in_force(config, *hologram, slm.load_lut(), slm.load_flatness());
  instrument->archive_.use_slm(*state.slm);
  auto renderer = make_renderer(state.slm->hologram);
  if (!renderer) return fail(renderer.error());
  state.renderer = *renderer;
  instrument->references_ = instrument->archive_.load();
  state.registration = instrument->registrations_.load();
  if (state.registration && !instrument->plan_for(state, 0)) state.registration.reset();
  instrument->limit_pictures();
  instrument->calibrations_.load();
  HologramRequest first = instrument->render(state);
  auto plan = instrument->plan_for(state, first.hologram_id);
  if (!plan) return fail(plan.error());
  instrument->shown_hologram_id_ = first.hologram_id;
  instrument->grey_ = first.grey;
  instrument->deps_.slm.show_when_possible(std::move(first));
  instrument->adopt(state, std::move(*plan));
  return instrument;
}

Instrument::Instrument(const Config& config, const InstrumentDeps& deps, HologramConfig hologram,
                       State state)
    : optics_(config.optics),
      slm_geometry_(config.slm.geometry),
      workers_(config.pipeline.workers),
      deps_(deps),
      hologram_(std::move(hologram)),
      archive_(ReferenceBench(config, hologram_), deps.store, deps.events),
      registrations_(config.slm.geometry, deps.store, deps.events),
      slm_archive_(config, hologram_, deps.store, deps.events),
      state_(std::move(state)),
      calibrations_(archive_.bench(), deps.store, deps.events) {}

bool Instrument::do_work() {
  const bool worked = mailbox_.run_one(kTurn);
  watch_reference_job();
  retire_plans();
  return worked;
}

void Instrument::change_sensor(SensorSet change, Changed done) {
  mailbox_.post([this, change, done = std::move(done)] {
    auto next = changed_state(change);
    if (!next) return done(fail(next.error()));
    done(change_to(std::move(*next)));
  });
}

Result<Instrument::State> Instrument::changed_state(const SensorSet& change) const {
  State next = state_;
  const SensorSettings changed = change.applied_to({state_.sensor, state_.tracking});
  next.sensor = changed.sensor;
  next.tracking = changed.tracking;
  if (auto there = check_operator(change, next); !there) return fail(there.error());
  if (auto fast = check_daemon_tracker(next.tracking); !fast) return fail(fast.error());
  const auto lattice = make_lattice(next.sensor, slm_geometry_);
  if (!lattice) return fail(lattice.error());
  const SpotBench bench{*lattice,        next.sensor,   next.tracking,
                        optics_of(next), slm_geometry_, next.roi};
  if (auto apart = check_spots_apart(bench); !apart) return fail(apart.error());
  return next;
}

void Instrument::set_aberration(std::vector<Mode> modes, Changed done) {
  mailbox_.post([this, modes = std::move(modes), done = std::move(done)]() mutable {
    State next = state_;
    next.aberration = std::move(modes);
    if (auto free = check_not_held(); !free) return done(fail(free.error()));
    done(carry_out(std::move(next)));
  });
}

void Instrument::set_correction(std::vector<Mode> modes, Changed done) {
  mailbox_.post([this, modes = std::move(modes), done = std::move(done)]() mutable {
    State next = state_;
    next.correction = std::move(modes);
    done(change_to(std::move(next)));
  });
}

void Instrument::show(HologramKind pattern, Changed done) {
  mailbox_.post([this, pattern, done = std::move(done)] {
    State next = state_;
    next.pattern = pattern;
    next.painted.reset();
    done(change_to(std::move(next)));
  });
}

void Instrument::follow(std::uint64_t plan_id, std::optional<TornSpots> torn) {
  mailbox_.post([this, plan_id, torn = std::move(torn)]() mutable {
    if (snapshot_.get().plan_id != plan_id || reference_job_ || lease_ || (!torn && !torn_)) return;
    torn_ = std::move(torn);
    auto plan = plan_for(state_, shown_hologram_id_);
    if (!plan) return torn_.reset();  // as the plan in use: it would be the same error
    adopt(state_, std::move(*plan));
  });
}

Result<void> Instrument::can_measure(PixelFormat format) const {
  if (traits_of(format).filter == ColourFilter::none) return {};
  const SensorSnapshot now = snapshot();
  const auto tracker =
      make_tracker(now.tracking, spot_model(now.sensor, now.optics, slm_geometry_, format));
  if (!tracker) return fail(Errc::refused, "pixel_format", tracker.error().reason);
  return {};
}

void Instrument::camera_changed(const CameraSettings& camera,
                                const std::optional<CameraInfo>& info) {
  mailbox_.post([this, camera, info] {
    if (reference_job_ && camera_ && !(camera == *camera_)) {
      fail_reference(Error{Errc::refused, "camera", "the camera's settings changed meanwhile"});
    }
    camera_ = camera;
    const bool same_reference = know_camera(info);
    check_registration();
    check_flatness();
    if (same_reference && camera.roi == state_.roi && camera.pixel_format == state_.format) {
      return tell_stale();
    }
    State next = state_;
    next.roi = camera.roi;
    next.format = camera.pixel_format;
    ++next.sensor_epoch;
    torn_.reset();
    auto plan = plan_for(next, shown_hologram_id_);
    if (!plan) {
      state_.roi = next.roi;  // so that what is changed next is planned for this image
      state_.format = next.format;
      return deps_.events.emit("sensor", Severity::error,
                               "no plan for the camera's image: " + plan.error().reason);
    }
    // The same picture stays on the SLM, but what is measured of it belongs to the new image.
    deps_.slm.show_when_possible({shown_hologram_id_, shown_epoch(next), next.pattern, grey_});
    adopt(std::move(next), std::move(*plan));
  });
}

std::function<void(const std::string&)> Instrument::when_tried(
    std::function<void(const std::string&)> know, Changed done) {
  auto answer = std::make_shared<Changed>(std::move(done));
  return [this, know = std::move(know), answer](const std::string& sha256) {
    mailbox_.post([this, know, answer, sha256] {
      if (know && !sha256.empty()) know(sha256);
      if (const Changed once = std::exchange(*answer, nullptr)) once(snapshot_.get());
    });
  };
}

DaemonStore::Dropped Instrument::when_dropped(SensorSnapshot changed,
                                              std::function<void()> put_back, Changed done) {
  return [this, changed = std::move(changed), put_back = std::move(put_back),
          done = std::move(done)](const Result<void>& dropped) {
    mailbox_.post([this, changed, put_back, done, dropped] {
      if (dropped) return done(changed);
      Error why = dropped.error();
      if (check_free()) {
        put_back();
      } else {
        why.reason += "; it is not used any more, and a restart loads it";
      }
      done(fail(std::move(why)));
    });
  };
}

/// Prepares everything, shows it, and only then makes it the state; on any error nothing has
/// changed.
Result<SensorSnapshot> Instrument::change_to(State next) {
  if (auto free = check_free(); !free) return fail(free.error());
  return carry_out(std::move(next));
}

Result<void> Instrument::check_free() const {
  if (auto free = check_not_held(); !free) return free;
  if (!looping_) return {};
  return fail(Errc::refused, "", "the loop is closed; open it with loop.open first");
}

Result<void> Instrument::check_not_held() const {
  if (reference_job_) {
    return fail(
        Errc::refused, "",
        fmt::format("job {} is taking a reference: wait for it or cancel it", *reference_job_));
  }
  if (lease_) {
    return fail(Errc::refused, "",
                fmt::format("job {} has the sensor: wait for it or cancel it", lease_->job));
  }
  if (reloading_) {
    return fail(Errc::refused, "",
                "the configuration is being reloaded; repeat the request in a moment");
  }
  return {};
}

/// Of the state's own sensor and SLM.
Result<void> Instrument::renew_renderer(State& state) {
  HologramConfig hologram = state.slm->hologram;
  hologram.sensor = state.sensor;
  auto renderer = make_renderer(hologram);
  if (!renderer) return fail(renderer.error());
  state.renderer = *renderer;
  ++state.sensor_epoch;
  return {};
}

Result<SensorSnapshot> Instrument::carry_out(State next) {
  const bool new_sensor = !(next.sensor == state_.sensor);
  const bool new_slm = next.slm != state_.slm;
  const bool new_picture = new_sensor || new_slm || next.pattern != state_.pattern ||
                           !(shown_modes(next) == shown_modes(state_)) ||
                           next.painted != state_.painted;
  if (new_sensor || new_slm) {
    if (auto made = renew_renderer(next); !made) return fail(made.error());
  }
  const bool has_modes =
      next.pattern == HologramKind::sensor || next.pattern == HologramKind::grating;
  if (has_modes) {
    auto sampled = next.renderer->check_sampling(shown_modes(next));
    if (!sampled) return fail(sampled.error());
  }
  auto plan = plan_for(next, new_picture ? next_hologram_id_ : shown_hologram_id_, nullptr);
  if (!plan) return fail(plan.error());
  if (new_picture) {
    HologramRequest request = render(next);
    const std::uint64_t hologram_id = request.hologram_id;
    const auto grey = request.grey;
    if (auto shown = deps_.slm.show(std::move(request)); !shown) return fail(shown.error());
    shown_hologram_id_ = hologram_id;
    grey_ = grey;
  } else if (next.sensor_epoch != state_.sensor_epoch) {
    // The same picture stays on the SLM, but what is measured of it means something else.
    deps_.slm.show_when_possible({shown_hologram_id_, shown_epoch(next), next.pattern, grey_});
  }
  torn_.reset();  // those of the plan that is now left
  adopt(std::move(next), std::move(*plan));
  return snapshot_.get();
}

/// 0, nothing to measure, unless the picture is the sensor's.
std::uint64_t Instrument::shown_epoch(const State& state) {
  return state.pattern == HologramKind::sensor ? state.sensor_epoch : 0;
}

/// What is added to the pattern: the aberration less the correction. The corrected beam, for which
/// the grating is shown, has no aberration of ours.
std::vector<Mode> Instrument::shown_modes(const State& state) {
  std::vector<Mode> modes;
  if (state.pattern != HologramKind::grating) modes = state.aberration;
  for (const Mode& correction : state.correction) {
    const auto same = std::find_if(modes.begin(), modes.end(),
                                   [&](const Mode& mode) { return mode.j == correction.j; });
    if (same == modes.end()) {
      modes.push_back({correction.j, -correction.waves});
    } else {
      same->waves -= correction.waves;
    }
  }
  return modes;
}

HologramRequest Instrument::render(const State& state) {
  if (state.painted) {
    return {next_hologram_id_++, shown_epoch(state), state.pattern, state.painted};
  }
  auto grey = std::make_shared<Image<std::uint8_t>>();
  state.renderer->render(state.pattern, shown_modes(state), *grey);
  return {next_hologram_id_++, shown_epoch(state), state.pattern, std::move(grey)};
}

Result<std::unique_ptr<MeasurementPlan>> Instrument::plan_for(const State& state,
                                                              std::uint64_t hologram_id) {
  return plan_for(state, hologram_id, torn_ ? &*torn_ : nullptr);
}

Result<std::unique_ptr<MeasurementPlan>> Instrument::plan_for(const State& state,
                                                              std::uint64_t hologram_id,
                                                              const TornSpots* torn) {
  const std::optional<Reference> reference = reference_for(state);
  return build_plan({next_plan_id_++, state.sensor_epoch, hologram_id, state.renderer->lattice(),
                     state.sensor, state.tracking, optics_of(state), slm_geometry_, state.roi,
                     state.format, lit_pixels(state.format, optics_.wavelength_nm),
                     shown_modes(state), reference, workers_, torn,
                     templates_for(state, reference).banks, operator_for(state)});
}

const OwnTemplates& Instrument::templates_for(const State& state,
                                              const std::optional<Reference>& reference) {
  return templates_.of(state.tracking,
                       spot_model(state.sensor, optics_of(state), slm_geometry_, state.format),
                       reference);
}

void Instrument::adopt(State state, std::unique_ptr<MeasurementPlan> plan) {
  state_ = std::move(state);
  SensorSnapshot now;
  now.sensor = state_.sensor;
  now.tracking = state_.tracking;
  now.pattern = state_.pattern;
  now.aberration = state_.aberration;
  now.correction = state_.correction;
  now.hologram_id = shown_hologram_id_;
  now.sensor_epoch = state_.sensor_epoch;
  now.optics = optics_of(state_);
  now.registration = registration_of(state_);
  now.plan_id = plan->id;
  now.subapertures = plan->subapertures();
  now.modes_j = plan->reconstructor->modes_j();
  now.reference = reference_for(state_);
  now.calibration = calibrations_.find(calibration_key(state_));
  now.slm = state_.slm;
  now.templates = templates_for(state_, now.reference).report;
  now.mode_operator = report_operator(*plan);
  if (torn_) now.torn = torn_->numbers();
  judge_layout();
  now.layout_fault = layout_fault_;
  const SensorSnapshot before = snapshot_.get();
  tell_torn(before.torn, now.torn);
  tell_operator(before.mode_operator.in_force, now.mode_operator.in_force);
  deps_.on_plan(*plan, now);
  snapshot_.set(std::move(now));
  deps_.pipeline.use_plan(plan.get());
  plans_.push_back(std::move(plan));
  tell_stale();
}

/// Whether the camera can see the spots. If not, all goes on: a region or a spacing that works can
/// still be set.
void Instrument::judge_layout() {
  const OpticsConfig optics = optics_of(state_);
  LayoutKey key{state_.sensor, state_.tracking.tracker, optics.registered, optics.centre_px,
                state_.roi};
  if (layout_key_ == key) return;
  const bool first = !layout_key_;
  layout_key_ = std::move(key);
  const SpotBench bench{state_.renderer->lattice(),
                        state_.sensor,
                        state_.tracking,
                        optics,
                        slm_geometry_,
                        state_.roi};
  auto seen = check_spots_apart(bench);
  if (seen) seen = check_spots_in_region(bench);
  layout_fault_ = seen ? "" : seen.error().field + ": " + seen.error().reason;
  if (seen) return;
  deps_.events.emit("sensor", first ? Severity::error : Severity::warning, layout_fault_,
                    {{"field", seen.error().field}});
}

void Instrument::tell_torn(const std::vector<int>& before, const std::vector<int>& now) {
  if (now == before) return;
  deps_.events.emit("spots", Severity::info,
                    now.empty() ? "all spots are followed as round ones again"
                                : fmt::format("the wavefront has torn spots {}: they are followed "
                                              "by the shapes that it gives them",
                                              fmt::join(now, ", ")),
                    {{"torn", now}});
}

void Instrument::retire_plans() {
  const std::uint64_t oldest = deps_.pipeline.oldest_plan_in_use();
  while (plans_.size() > 1 && plans_.front()->id < oldest) plans_.pop_front();
}

}  // namespace ovws
