#include "core/optics/lattice.hpp"
#include "daemon/ovwsd/sensor/instrument.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {

/// A registration counts from the corner of the camera's sensor, all else from that of the region.
OpticsConfig Instrument::optics_of(const State& state) const {
  OpticsConfig optics = optics_;
  if (!state.registration) return optics;
  const Registration map = *registration_of(state);
  optics.registered = map.px_per_cycle;
  optics.centre_px = map.base_px - Vec2{double(state.roi.x), double(state.roi.y)};
  return optics;
}

/// With the base of the sensor that is shown, whatever it was measured with.
std::optional<Registration> Instrument::registration_of(const State& state) const {
  if (!state.registration) return std::nullopt;
  return rebased(*state.registration, base_grating_cpp(state.sensor, slm_geometry_));
}

Result<SensorSnapshot> Instrument::change_registration(
    const std::optional<Registration>& registration) {
  State next = state_;
  next.registration = registration;
  ++next.sensor_epoch;  // tracks of before lead nowhere
  const std::optional<Reference> before = reference_for(state_);
  auto changed = carry_out(std::move(next));
  if (changed && before && !changed->reference) {
    deps_.events.emit("reference", Severity::warning,
                      title_of(*before) +
                          " is not used: spots are now expected elsewhere than when it was taken; "
                          "take another one",
                      {{"t_taken_ns", before->t_taken_ns}, {"used", false}});
  }
  return changed;
}

void Instrument::clear_registration(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    if (auto free = check_free(); !free) return done(fail(free.error()));
    const auto before = state_.registration;
    auto changed = change_registration(std::nullopt);
    if (!changed) return done(std::move(changed));
    const auto put_back = [this, before] {
      if (before && !state_.registration) (void)change_registration(before);
    };
    registrations_.drop(when_dropped(std::move(*changed), put_back, done));
  });
}

/// Another camera stands otherwise.
void Instrument::check_registration() {
  if (!state_.registration || !registrations_.is_of_another(camera_info_)) return;
  deps_.events.emit("registration", Severity::warning,
                    "the registration is not used: it was measured with another camera",
                    {{"t_taken_ns", state_.registration->t_taken_ns}, {"used", false}});
  if (auto changed = change_registration(std::nullopt); changed) return;
  state_.registration.reset();  // without a display; the next plan is without it
}

/// The state that this job may change.
Result<Instrument::State> Instrument::lent_state(int job) const {
  if (lease_ && lease_->job == job) return state_;
  return fail(Errc::refused, "", "the sensor does not belong to this job");
}

void Instrument::use_registration(int job, const Registration& registration, Changed done) {
  mailbox_.post([this, job, registration, done = std::move(done)] {
    if (auto lent = lent_state(job); !lent) return done(fail(lent.error()));
    if (!deps_.jobs.runs(job)) return done(fail(Errc::refused, "", "it was cancelled"));
    auto changed = change_registration(registration);
    if (!changed) return done(std::move(changed));
    registrations_.keep(registration, camera_info_, when_tried(nullptr, done));
  });
}

void Instrument::lend(int job) {
  lease_ = Lease{job, state_.sensor, state_.tracking, state_.pattern, state_.aberration};
}

void Instrument::exhibit(int job, Exhibit exhibit, Changed done) {
  mailbox_.post([this, job, exhibit = std::move(exhibit), done = std::move(done)] {
    auto next = lent_state(job);
    if (!next) return done(fail(next.error()));
    const SensorSettings changed = exhibit.sensor.applied_to({state_.sensor, state_.tracking});
    next->sensor = changed.sensor;
    next->tracking = changed.tracking;
    if (auto fast = check_daemon_tracker(next->tracking); !fast) return done(fail(fast.error()));
    next->aberration = exhibit.aberration;
    next->painted.reset();
    next->pattern = HologramKind::sensor;
    if (exhibit.paint) {
      auto grey = std::make_shared<Image<std::uint8_t>>();
      exhibit.paint(*state_.renderer, *grey);
      next->painted = std::move(grey);
      next->pattern = HologramKind::test;
    }
    done(carry_out(std::move(*next)));
  });
}

void Instrument::give_back(int job, std::function<void()> then) {
  mailbox_.post([this, job, then = std::move(then)] {
    if (lease_ && lease_->job == job) {
      State before = state_;
      before.sensor = lease_->sensor;
      before.tracking = lease_->tracking;
      before.pattern = lease_->pattern;
      before.aberration = lease_->aberration;
      before.painted.reset();
      if (!carry_out(before)) fall_back_to(std::move(before));
      lease_.reset();
    }
    then();
  });
}

/// Without a display: it is to show this when it comes back.
void Instrument::fall_back_to(State before) {
  if (!(before.sensor == state_.sensor) && !renew_renderer(before)) return;
  HologramRequest request = render(before);
  auto plan = plan_for(before, request.hologram_id);
  if (!plan) return;  // the state's own plan was made before: it is no error of the plan
  shown_hologram_id_ = request.hologram_id;
  grey_ = request.grey;
  deps_.slm.show_when_possible(std::move(request));
  adopt(std::move(before), std::move(*plan));
}

}  // namespace ovws
