#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "core/optics/lattice.hpp"
#include "daemon/instrument.hpp"

namespace ovws {
namespace {

constexpr double kSamePlace = 0.25;  // lambda/d

}  // namespace

/// A registration counts from the corner of the camera's sensor, all else from that of the region.
OpticsConfig Instrument::optics_of(const State& state) const {
  OpticsConfig optics = optics_;
  if (!state.registration) return optics;
  optics.registered = state.registration->px_per_cycle;
  optics.centre_px = state.registration->base_px - Vec2{double(state.roi.x), double(state.roi.y)};
  return optics;
}

/// Positions measured by a camera that has moved since would send every tracker astray.
void Instrument::drop_references_if_moved(const State& next) {
  const auto spots_of = [this](const State& state) {
    return model_spots_px(state.renderer->lattice(), state.sensor, slm_geometry_, optics_of(state),
                          state.roi.width, state.roi.height);
  };
  const std::vector<Vec2> before = spots_of(state_), after = spots_of(next);
  double farthest_px = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    farthest_px = std::max(farthest_px, norm(after[i] - before[i]));
  }
  const double lambda_d = lambda_d_px(optics_of(next), slm_geometry_, next.sensor);
  if (farthest_px <= kSamePlace * lambda_d || references_.empty()) return;
  references_.clear();
  deps_.events.emit("reference", Severity::warning,
                    fmt::format("spots are now expected up to {:.1f} px from where they were: the "
                                "references of before mean nothing any more, take them anew",
                                farthest_px));
}

/// What `change` makes of the map; on an error the references of before stay.
Result<SensorSnapshot> Instrument::change_registration(
    const std::optional<Registration>& registration) {
  State next = state_;
  next.registration = registration;
  ++next.sensor_epoch;  // tracks of before lead nowhere
  std::vector<Reference> before = references_;
  drop_references_if_moved(next);
  auto changed = carry_out(std::move(next));
  if (!changed) references_ = std::move(before);
  return changed;
}

void Instrument::clear_registration(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    if (auto free = check_free(); !free) return done(fail(free.error()));
    done(change_registration(std::nullopt));
  });
}

/// The state that this job may change.
Result<Instrument::State> Instrument::lent_state(int job) const {
  if (lease_ && lease_->job == job) return state_;
  return fail(Errc::refused, "", "the sensor does not belong to this job");
}

void Instrument::use_registration(int job, const Registration& registration, Changed done) {
  mailbox_.post([this, job, registration, done = std::move(done)] {
    if (auto lent = lent_state(job); !lent) return done(fail(lent.error()));
    done(change_registration(registration));
  });
}

Result<void> Instrument::lend(int job) {
  if (auto free = check_free(); !free) return free;
  lease_ = Lease{job, state_.pattern, state_.aberration};
  return {};
}

void Instrument::exhibit(int job, Exhibit exhibit, Changed done) {
  mailbox_.post([this, job, exhibit = std::move(exhibit), done = std::move(done)] {
    auto next = lent_state(job);
    if (!next) return done(fail(next.error()));
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
  HologramRequest request = render(before);
  auto plan = plan_for(before, request.hologram_id);
  if (!plan) return;  // the state's own plan was made before: it is no error of the plan
  shown_hologram_id_ = request.hologram_id;
  grey_ = request.grey;
  deps_.slm.show_when_possible(std::move(request));
  adopt(std::move(before), std::move(*plan));
}

}  // namespace ovws
