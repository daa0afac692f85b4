#include "daemon/ovwsd/sensor/instrument.hpp"

namespace ovws {

void Instrument::begin_loop(Changed done) {
  mailbox_.post([this, done = std::move(done)] {
    if (auto free = check_free(); !free) return done(fail(free.error()));
    if (state_.pattern != HologramKind::sensor) {
      return done(fail(Errc::refused, "",
                       "the SLM does not show the sensor: call slm.show with \"sensor\" first"));
    }
    if (!reference_for(state_)) {
      return done(fail(Errc::refused, "reference",
                       "there is no reference to steer to: take one with reference.take first"));
    }
    looping_ = true;
    done(snapshot_.get());
  });
}

void Instrument::end_loop() {
  mailbox_.post([this] { looping_ = false; });
}

void Instrument::correct(std::vector<Mode> modes, Changed done) {
  mailbox_.post([this, modes = std::move(modes), done = std::move(done)]() mutable {
    if (auto free = check_not_held(); !free) return done(fail(free.error()));
    State next = state_;
    next.correction = std::move(modes);
    done(carry_out(std::move(next)));
  });
}

}  // namespace ovws
