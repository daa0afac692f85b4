#include "core/rt/counters.hpp"

namespace ovws {
namespace {

constexpr auto kCounters = std::to_array<CounterRow>({
    {"frames_grabbed", "Complete frames received from the camera in order."},
    {"frames_lost", "Frame numbers missing in the camera's sequence.", true},
    {"frames_incomplete", "Frames with missing packets.", true},
    {"frames_duplicated", "Frames received a second time.", true},
    {"frames_out_of_order", "Frames received after a later one.", true},
    {"frames_late", "Frames that arrived too late, which are not valid.", true},
    {"frames_left_justified", "Frames with MSB-aligned pixels, which were shifted right."},
    {"frames_unplanned", "Frames not measured because there was no measurement plan.", true},
    {"frames_unexpected", "Frames not measured because of an unexpected size or format.", true},
    {"frames_dropped", "Frames dropped because the daemon was too slow.", true},
    {"frames_unsettled",
     "Frames that were not settled: the hologram was changing or was not the sensor's, the "
     "region had just changed, the display had a fault, or the frame was late."},
    {"frames_invalid", "Frames published without a valid wavefront."},
    {"frames_unexplained", "Invalid frames whose spot positions no wavefront explains.", true},
    {"frames_published", "Frames published."},
    {"spots_lost", "Spots not found, summed over all frames.", true},
    {"acquisitions", "Searches for spots in the whole image."},
    {"messages_dropped", "Stream messages dropped because a queue of the daemon was full.", true},
    {"deadline_missed", "Frames published more than one frame period after their arrival.", true},
    {"camera_reconnects", "Reconnections of the camera.", true},
    {"display_faults", "Faults of the display.", true},
    {"requests", "Requests on the control socket."},
    {"requests_refused", "Requests that were refused."},
    {"clients_rejected", "Connection attempts without a known key."},
});
static_assert(kCounters.size() == std::size_t(Counter::count_));

}  // namespace

std::span<const CounterRow> all_counters() {
  return kCounters;
}

std::string_view counter_name(Counter counter) {
  return kCounters[std::size_t(counter)].name;
}

}  // namespace ovws
