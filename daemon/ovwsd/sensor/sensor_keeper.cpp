#include "daemon/ovwsd/sensor/sensor_keeper.hpp"

#include <spdlog/fmt/fmt.h>

#include <string_view>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"
#include "daemon/shared/slm_files.hpp"

namespace ovws {
namespace {

/// The request to show the hologram of `state`, whose levels are hologram_of(state).
HologramRequest request_of(const SensorState& state, std::uint64_t hologram_id,
                           std::shared_ptr<const Image<std::uint8_t>> levels) {
  return {hologram_id, shown_epoch(state), state.pattern, std::move(levels), shows_sequence(state)};
}

constexpr auto kMailboxWait = std::chrono::milliseconds(50);
constexpr auto kQuestionWait = std::chrono::milliseconds(5);
constexpr std::string_view kNoPlanRemedy =
    "change the camera's region or pixel format (camera.set), or the sensor (sensor.set)";

/// Whether the sensor has this reference and this calibration.
bool is_bound(const SensorSnapshot& sensor, const Bound& bound) {
  const auto &a = sensor.reference, &b = bound.reference;
  const bool same_reference = a && b ? a->t_taken_ns == b->t_taken_ns : !a && !b;
  return same_reference && sensor.calibration == bound.calibration;
}

/// The obstacle with this reason, which goes on if it was that of the snapshot before.
StatusMessage::SensorPart::Invalid obstacle_of(const std::string& reason, std::string_view action,
                                               const SensorSnapshot& before) {
  if (reason.empty()) return {};
  const bool goes_on = reason == before.obstacle.reason;
  return {goes_on ? before.obstacle.t_since_ns : utc_ns(), reason, std::string(action), 0, {}};
}

/// Warns if settings that a stored registration builds on have changed since it was measured
/// (`changed`), or if it is not used (`why_not`).
void warn_of_registration(const std::string& changed, const std::string& why_not, Events& events) {
  if (changed.empty() && why_not.empty()) return;
  std::string text;
  if (why_not.empty()) {
    text = "the stored registration was measured with other settings: " + changed +
           "; it is used as it was measured: if the bench has changed, run registration.run";
  } else {
    text = "the stored registration is not used: " + why_not +
           (changed.empty() ? "" : "; since it was measured, " + changed) +
           "; restore the settings, or run registration.run again";
  }
  events.emit("registration", Severity::warning, text, {{"used", why_not.empty()}});
}

}  // namespace

Result<std::unique_ptr<SensorKeeper>> SensorKeeper::make(const Config& config,
                                                         const SensorKeeperDeps& deps) {
  auto hologram = load_hologram_config(config);
  if (!hologram) return fail(hologram.error());
  std::unique_ptr<SensorKeeper> keeper(new SensorKeeper(config, deps, std::move(*hologram)));
  if (auto begun = keeper->begin(); !begun) return fail(begun.error());
  return keeper;
}

SensorKeeper::SensorKeeper(const Config& config, const SensorKeeperDeps& deps,
                           HologramConfig hologram)
    : deps_(deps),
      bench_(config, std::move(hologram), deps.library),
      plans_(deps.pipeline, bench_.optics),
      events_(bench_.optics, deps.events),
      snapshot_(std::make_shared<const SensorSnapshot>()) {
  state_.sensor = config.sensor;
  state_.tracking = config.tracking;
  state_.roi = config.camera.settings.roi;
  state_.format = config.camera.settings.pixel_format;
}

/// Loads the measurements stored on disk and activates the first plan.
Result<void> SensorKeeper::begin() {
  SensorEdit edit = new_edit();
  SensorState& state = edit.state;
  load_slm(state);
  auto drawn = renew_renderer(state);
  if (!drawn && state.registration) {  // a stored array that no lattice can be made of
    drop_registration(state, bench_.config.sensor);
    drawn = renew_renderer(state);
  }
  if (!drawn) return drawn;
  load_measured(edit);
  bench_.hologram_id = next_hologram_id_++;
  const auto planned = [&] {
    return plans_.build(state, bind(state, edit.knowledge, bench_.optics), bench_.hologram_id);
  };
  auto plan = planned();
  if (state.registration) {
    const BenchKey then = state.registration->key,
                   now = key_of(state, edit.knowledge, bench_.optics);
    warn_of_registration(words_of(differing(respect::kRegistrationSettings, then, now), then, now),
                         plan ? "" : plan.error().reason, deps_.events);
  }
  if (!plan && state.registration) {
    drop_registration(state, bench_.config.sensor);
    if (auto made = renew_renderer(state); !made) return made;
    plan = planned();
  }
  if (!plan) return fail(plan.error());
  bench_.levels = hologram_of(state);
  deps_.slm.show_when_possible(request_of(state, bench_.hologram_id, bench_.levels));
  const Bound bound = bind(state, edit.knowledge, bench_.optics);
  adopt(std::move(edit), bound, std::move(*plan));
  return {};
}

bool SensorKeeper::do_work() {
  const bool worked = mailbox_.run_one(questions_.empty() ? kMailboxWait : kQuestionWait);
  if (!questions_.empty() && spare_time_.is_due()) {
    const auto question = std::move(questions_.front());
    questions_.pop_front();
    spare_time_.run([&] { question(new_edit()); });
  }
  plans_.retire();
  return worked;
}

void SensorKeeper::edit(SensorChange change, Done done, std::function<void()> active) {
  mailbox_.post(
      [this, change = std::move(change), done = std::move(done), active = std::move(active)] {
        SensorEdit edit = new_edit();
        if (auto made = change(edit); !made) return done(fail(made.error()));
        if (!edit.files_only) {
          if (auto used = activate(edit, Show::now); !used) return done(fail(used.error()));
        }
        if (active) active();
        update_files(edit.stored, std::move(edit.removed), done);
      });
}

void SensorKeeper::ask(std::function<void(const SensorEdit&)> question) {
  mailbox_.post([this, question = std::move(question)] { question(new_edit()); });
}

void SensorKeeper::ask_in_spare_time(std::function<void(const SensorEdit&)> question) {
  mailbox_.post([this, question = std::move(question)] { questions_.push_back(question); });
}

void SensorKeeper::take_turn(Holder holder, std::function<void()> then) {
  mailbox_.post([this, holder, then = std::move(then)] {
    if (holder != state_.holder) {
      if (before_job_) restore_from_before_job();
      if (holder == Holder::job) before_job_ = state_;
      set_holder(holder);
      if (holder == Holder::nobody) publish_stale();
    }
    if (then) then();
  });
}

void SensorKeeper::set_holder(Holder holder) {
  const bool took = takes_templates(state_);
  state_.holder = holder;
  holder_.store(holder);
  if (took != takes_templates(state_)) plan_again(new_edit());
}

/// Builds a plan for the edit and activates both; the hologram stays unchanged. If no plan can be
/// built, nothing changes.
void SensorKeeper::plan_again(SensorEdit edit) {
  const Bound bound = bind(edit.state, edit.knowledge, bench_.optics);
  auto plan = plans_.build(edit.state, bound, bench_.hologram_id);
  if (plan) adopt(std::move(edit), bound, std::move(*plan));
}

void SensorKeeper::restore_from_before_job() {
  SensorEdit edit = new_edit();
  static_cast<SensorShown&>(edit.state) = *before_job_;
  edit.state.painted.reset();
  before_job_.reset();
  if (same_hologram(edit.state, state_) && edit.state.tracking == state_.tracking) return;
  const auto restored = activate(edit, Show::when_possible);
  if (!restored) adopt_without_plan(std::move(edit), restored.error());
}

void SensorKeeper::use_templates(ActiveTemplates templates) {
  mailbox_.post([this, templates = std::move(templates)]() mutable {
    const bool usable = !templates.fit || templates.made_for.sensor_epoch == state_.sensor_epoch;
    const bool changes = !(templates == state_.templates);
    if (!takes_templates(state_) || !usable || !changes) return;
    SensorEdit edit = new_edit();
    edit.state.templates = std::move(templates);
    plan_again(std::move(edit));
  });
}

void SensorKeeper::camera_changed(const CameraSettings& camera,
                                  const std::optional<CameraInfo>& info) {
  mailbox_.post([this, camera, info] {
    bench_.camera = camera;
    SensorEdit edit = new_edit();
    edit.knowledge.camera = info;
    discard_for_camera(edit);
    SensorState& next = edit.state;
    const Bound now = bind(next, edit.knowledge, bench_.optics);
    const bool same_image = camera.roi == next.roi && camera.pixel_format == next.format;
    const bool other_camera = differing(respect::kCamera, key_of(state_, knowledge_, bench_.optics),
                                        key_of(next, edit.knowledge, bench_.optics)) != 0;
    const bool same_sensor = next.sensor_epoch == state_.sensor_epoch && next.slm == state_.slm;
    if (same_image && same_sensor && !other_camera && is_bound(*snapshot(), now)) {
      knowledge_ = std::move(edit.knowledge);
      return publish_stale();
    }
    next.roi = camera.roi;
    next.format = camera.pixel_format;
    ++next.sensor_epoch;
    if (const auto used = activate(edit, Show::when_possible); !used) {
      adopt_without_plan(std::move(edit), used.error());  // the next plan is for this image
    }
  });
}

/// Stops using the registration or the flatness if it was measured with another camera, because
/// that camera's position and optics differ.
void SensorKeeper::discard_for_camera(SensorEdit& edit) {
  SensorState& state = edit.state;
  const BenchKey now = key_of(state, edit.knowledge, bench_.optics);
  const auto other_camera = [&now](const BenchKey& then) {
    return words_of(differing(respect::kCamera, then, now), then, now);
  };
  if (const std::string why = state.registration ? other_camera(state.registration->key) : "";
      !why.empty()) {
    deps_.events.emit("registration", Severity::warning,
                      "the registration is not used: " + why + "; run registration.run",
                      {{"t_taken_ns", state.registration->t_taken_ns}, {"used", false}});
    if (edit.before_job && !state.registration->array.empty()) {
      edit.before_job->sensor = bench_.config.sensor;
    }
    drop_registration(state, bench_.config.sensor);
  }
  const auto& flatness = state.slm->flatness;
  if (const std::string why = flatness ? other_camera(flatness->key) : ""; !why.empty()) {
    deps_.events.emit(
        "slm", Severity::warning,
        "the flatness is not used, and its file is kept: " + why + "; run flatness.run",
        {{"t_taken_ns", flatness->t_taken_ns}, {"used", false}});
    state.slm = active_slm(bench_.config, bench_.hologram, state.slm->lut, nullptr);
  }
}

/// Builds the plan and shows the hologram, then adopts the edit. If any step returns an error, the
/// sensor's state stays unchanged.
Result<void> SensorKeeper::activate(SensorEdit edit, Show show) {
  SensorState& next = edit.state;
  const bool new_slm = next.slm != state_.slm;
  if (new_slm || !(next.sensor == state_.sensor)) {
    const bool drawn = !new_slm && next.renderer != state_.renderer;  // by the change itself
    if (!drawn) {
      if (auto made = renew_renderer(next); !made) return made;
    }
    ++next.sensor_epoch;
  }
  if (!(next.tracking == state_.tracking)) next.templates = {};
  if (auto sampled = check_sampling(next); !sampled) return sampled;
  const bool same = same_hologram(next, state_);
  const std::uint64_t hologram_id = same ? bench_.hologram_id : next_hologram_id_++;
  Bound bound = bind(next, edit.knowledge, bench_.optics);
  auto plan = plans_.build(next, bound, hologram_id);
  if (!plan) return fail(plan.error());
  if (auto shown = present(next, hologram_id, show); !shown) return shown;
  if (new_slm && use_waiting(edit)) {
    const Bound more = bind(next, edit.knowledge, bench_.optics);
    if (auto with_more = plans_.build(next, more, hologram_id)) {
      plan = std::move(with_more);
      bound = more;
    }
  }
  adopt(std::move(edit), bound, std::move(*plan));
  return {};
}

/// Shows the hologram if it has changed. If the display does not take it in time, its number is not
/// used for another hologram, because this one may have been visible for a moment.
Result<void> SensorKeeper::present(const SensorState& next, std::uint64_t hologram_id, Show show) {
  if (hologram_id != bench_.hologram_id) {
    const HologramRequest request = request_of(next, hologram_id, hologram_of(next));
    const auto shown = deps_.slm.show(request);
    if (!shown && show == Show::now) return shown;
    if (!shown) deps_.slm.show_when_possible(request);
    bench_.hologram_id = hologram_id;
    bench_.levels = request.levels;
  } else if (next.sensor_epoch != state_.sensor_epoch) {
    // The hologram on the SLM stays, but measurements of it now belong to a new epoch.
    deps_.slm.show_when_possible(request_of(next, hologram_id, bench_.levels));
  }
  return {};
}

void SensorKeeper::adopt(SensorEdit edit, const Bound& bound,
                         std::unique_ptr<MeasurementPlan> plan) {
  const SensorView before = snapshot();
  state_ = std::move(edit.state);
  knowledge_ = std::move(edit.knowledge);
  if (before_job_) before_job_ = std::move(edit.before_job);
  auto now = std::make_shared<SensorSnapshot>();
  describe(*now, bound);
  now->mode_operator = {plan->mode_operator, bound.operator_reason};
  now->plan_id = plan->id;
  now->subapertures = plan->subapertures();
  now->beams = beams_of(*plan);
  now->region = plan->region;
  now->modes_j = plan->modes_j;
  now->position_modes_j = plan->reconstructor->modes_j();
  now->given_up =
      plan->wants_templates() && !plan->fit && !plan->awaits_templates && takes_templates(state_);
  events_.publish_changes(*before, *now);
  deps_.on_plan(*plan, now);
  snapshot_.set(now);
  plans_.use(std::move(plan));
  publish_stale();
}

/// Adopts an edit from which no plan can be built. Only for changes that cannot be refused: another
/// camera, or the end of a job. No frame is valid until a plan can be built: the hologram belongs
/// to a newer epoch than the active plan.
void SensorKeeper::adopt_without_plan(SensorEdit edit, const Error& why) {
  ++edit.state.sensor_epoch;
  (void)renew_renderer(edit.state);
  const bool same = same_hologram(edit.state, state_);
  (void)present(edit.state, same ? bench_.hologram_id : next_hologram_id_++, Show::when_possible);
  state_ = std::move(edit.state);
  knowledge_ = std::move(edit.knowledge);
  if (before_job_) before_job_ = std::move(edit.before_job);
  auto now = std::make_shared<SensorSnapshot>(*snapshot());
  describe(*now, bind(state_, knowledge_, bench_.optics));
  now->plan_id = 0;
  const std::string reason = "the camera's image cannot be measured: " + why.reason;
  now->obstacle = obstacle_of(reason, kNoPlanRemedy, *snapshot());
  snapshot_.set(now);
  deps_.events.emit("sensor", Severity::error, reason);
  publish_stale();
}

/// Writes the state, and what is bound to it, into its snapshot. Events report what changes.
void SensorKeeper::describe(SensorSnapshot& now, const Bound& bound) {
  static_cast<SensorShown&>(now) = state_;
  now.correction = state_.correction;
  now.hologram_id = bench_.hologram_id;
  now.sensor_epoch = state_.sensor_epoch;
  now.templates_for = templates_key(state_, bound);
  now.optics = optics_of(state_, bench_.optics);
  now.registration = registration_of(state_, bench_.optics);
  now.layout_fault = events_.layout_fault(state_);
  now.reference = bound.reference;
  now.calibration = bound.calibration;
  now.slm = state_.slm;
  now.obstacle = {};
  if (bound.reference) return;
  const SensorView before = snapshot();
  now.obstacle = obstacle_of(missing_reference_reason(state_, knowledge_, bench_.optics),
                             kUnusedRemedy, *before);
  if (before->reference) events_.publish_unused(*before->reference, state_, knowledge_);
}

/// Not while camera and sensor change together: they fit each other again in the end.
void SensorKeeper::publish_stale() {
  if (state_.holder != Holder::nobody && state_.holder != Holder::loop) return;
  events_.publish_stale(snapshot()->reference.get(), bench_.camera);
}

/// Writes or removes the files of a change that is already in effect, then calls `done`. If a file
/// cannot be written, the change stays in effect. If a file cannot be removed, it is undone.
void SensorKeeper::update_files(const std::function<Library::Item()>& stored, RemovedItems removed,
                                Done done) {
  if (stored) {
    bench_.library.put(stored(), [this, done = std::move(done)](const Result<std::string>&) {
      mailbox_.post([this, done] { done(snapshot()); });
    });
  } else if (removed.kind != nullptr) {
    const ItemKind& kind = *removed.kind;
    const std::vector<std::string> names = removed.names;
    bench_.library.remove(kind, names,
                          [this, changed = snapshot(), removed = std::move(removed),
                           done = std::move(done)](const Result<void>& gone) {
                            mailbox_.post([this, changed, removed, done, gone] {
                              if (gone) return done(changed);
                              undo(removed, gone.error(), done);
                            });
                          });
  } else {
    done(snapshot());
  }
}

void SensorKeeper::undo(const RemovedItems& removed, Error why, const Done& done) {
  SensorEdit undo = new_edit();
  const auto lease = deps_.leases.take(Request::set_measured);
  if (lease) removed.put_back(undo);
  const Result<void> undone =
      lease ? activate(std::move(undo), Show::when_possible) : fail(lease.error());
  if (!undone) {
    why.reason += fmt::format(
        "; this could not be undone ({}): it is not used now, but the next restart will load it "
        "again",
        undone.error().reason);
  }
  done(fail(std::move(why)));
}

Result<void> check_shows_sensor(const SensorShown& sensor) {
  if (sensor.pattern != HologramKind::sensor) {
    return fail(Errc::refused, "",
                "the SLM does not show the sensor: call slm.show with \"sensor\" first");
  }
  return {};
}

Result<void> check_no_sequence(const SensorShown& sensor) {
  if (sensor.sequence.empty()) return {};
  return fail(Errc::refused, "",
              "the DMD shows a sequence of patterns: end it with aberration.clear first");
}

Result<void> check_shows_one_sensor(const SensorShown& sensor) {
  return check_shows_sensor(sensor).and_then([&] { return check_no_sequence(sensor); });
}

Result<void> can_measure(const SensorSnapshot& sensor, const SlmGeometry& slm, PixelFormat format) {
  if (traits_of(format).filter == ColourFilter::none) return {};
  const auto tracker =
      make_tracker(sensor.tracking, spot_model(sensor.sensor, sensor.optics, slm, format));
  if (!tracker) return fail(Errc::refused, "pixel_format", tracker.error().reason);
  return {};
}

}  // namespace ovws
