/// Exact waits of Aravis's thread: its fake camera waits in whole milliseconds, and polls without a
/// pause for the rest.
#pragma once

#include <cstdint>

namespace ovws::twin {

/// Until this time (UTC), each g_poll of this thread ends then at the latest and, without an event,
/// not before, whatever its timeout is.
void end_polls_at(std::int64_t utc_ns);

}  // namespace ovws::twin
