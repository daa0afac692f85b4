/// Exact waits of Aravis's thread: its fake camera waits in whole milliseconds, and polls without a
/// pause for the rest.
#pragma once

#include <cstdint>

namespace ovws::twin {

/// Ends the g_polls of this thread before this time (UTC) then, whatever their timeouts are.
void end_next_poll_at(std::int64_t utc_ns);

}  // namespace ovws::twin
