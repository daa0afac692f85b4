/// Exclusive access to the sensor. Every change that a client, a job or the loop asks for must pass
/// `may_change`.
#pragma once

#include <string>

#include "core/base/result.hpp"
#include "core/control/state_machine.hpp"

namespace ovws {

struct Hold {
  enum class By { nobody, job, loop, reload, lattice };
  By by = By::nobody;
  int job = 0;

  static Hold unheld() { return {}; }
  static Hold of_job(int number) { return {By::job, number}; }
  static Hold of_loop() { return {By::loop, 0}; }
  static Hold of_reload() { return {By::reload, 0}; }
  static Hold of_lattice() { return {By::lattice, 0}; }  ///< lattice.use

  /// Whether the holder changes the camera's settings together with the sensor.
  bool changes_camera() const { return by != By::nobody && by != By::loop; }
  friend bool operator==(const Hold&, const Hold&) = default;
};

/// Whether `as` may change the sensor while `now` holds the sensor. The holder may. A free sensor
/// may be changed by anyone except a job, a reload or lattice.use, which must hold the sensor
/// first. Request a change as the loop if it is allowed with the loop open or closed.
/// Errc::refused: the message says what to wait for.
inline Result<void> may_change(const Hold& now, const Hold& as) {
  if (now == as || (as.by == Hold::By::loop && now.by == Hold::By::nobody)) return {};
  if (as.by == Hold::By::job) {
    return fail(Errc::refused, "", "this job does not hold the sensor");
  }
  switch (now.by) {
    case Hold::By::job:
      return fail(Errc::refused, "",
                  "job " + std::to_string(now.job) + " holds the sensor: wait for it or cancel it");
    case Hold::By::loop:
      return fail(Errc::refused, "", "the loop is closed; open it with loop.open first");
    case Hold::By::reload:
      return fail(Errc::refused, "", std::string(control::kReloads));
    case Hold::By::lattice:
      return fail(Errc::refused, "", std::string(control::kLatticeChanges));
    case Hold::By::nobody:
      break;
  }
  return fail(Errc::refused, "", "this change needs the sensor to be held");
}

}  // namespace ovws
