#include "daemon/ovwsd/sensor/instrument.hpp"
#include "daemon/ovwsd/sensor/plan_builder.hpp"

namespace ovws {

Result<void> Instrument::begin_reload() {
  if (auto free = check_free(); !free) return free;
  reloading_ = true;
  return {};
}

void Instrument::reload_sensor(SensorSet change, Changed done) {
  mailbox_.post([this, change, done = std::move(done)] {
    auto next = changed_state(change);
    if (!next) return done(fail(next.error()));
    done(carry_out(std::move(*next)));
  });
}

void Instrument::end_reload(std::function<void()> then) {
  mailbox_.post([this, then = std::move(then)] {
    reloading_ = false;
    then();
  });
}

}  // namespace ovws
