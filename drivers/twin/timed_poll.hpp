/// Exact waits of Aravis's thread: its fake camera waits in whole milliseconds, and polls without a
/// pause for the rest.
#pragma once

#include <cstdint>

namespace ovws::twin {

/// Ends the next g_poll of this thread at this time (UTC) at the latest, whatever its timeout is.
void end_next_poll_at(std::int64_t utc_ns);

}  // namespace ovws::twin
