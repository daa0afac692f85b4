/// The functions of GLib that this program replaces for Aravis's fake camera: clock, poll and send.
#pragma once

#include <cstdint>

#include "drivers/twin/faults.hpp"

namespace ovws::twin {

/// The twin's clock, ns: UTC, but it steps only in `follow_utc`, between two frames. A wait for the
/// next frame is thus as long as it should be even if the wall clock steps back. Any thread.
std::int64_t twin_ns();
bool follow_utc();  ///< returns whether the clock stepped back

/// Until this time of the twin's clock, each g_poll of this thread ends then at the latest and,
/// without an event, not before, whatever its timeout is: Aravis waits in whole milliseconds, and
/// polls without a pause for the rest.
void end_polls_at(std::int64_t t_ns);

/// Delays write acknowledges while `faults` has slow_registers active; null: no more.
void delay_registers(const Faults* faults);

}  // namespace ovws::twin
