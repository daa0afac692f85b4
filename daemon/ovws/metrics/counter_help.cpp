/// Help text of each counter in `status.counters`.
#include <array>
#include <utility>

#include "daemon/ovws/metrics/families.hpp"

namespace ovws::metrics {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 23> kCounters{{
    {"frames_grabbed", "Complete frames received from the camera in order."},
    {"frames_lost", "Frame numbers missing in the camera's sequence."},
    {"frames_incomplete", "Frames with missing packets."},
    {"frames_duplicated", "Frames received a second time."},
    {"frames_out_of_order", "Frames received after a later one."},
    {"frames_late", "Frames that arrived too late, published as not valid."},
    {"frames_left_justified", "Frames with MSB-aligned pixels, which were shifted right."},
    {"frames_unplanned", "Frames not measured because there was no measurement plan."},
    {"frames_unexpected", "Frames not measured because of an unexpected size or format."},
    {"frames_dropped", "Frames dropped because the daemon was too slow."},
    {"frames_unsettled",
     "Frames published as not settled: the hologram was changing or was not the sensor's, the "
     "region had just changed, the display had a fault, or the frame was late."},
    {"frames_invalid", "Frames published without a valid wavefront."},
    {"frames_unexplained", "Invalid frames whose spot positions no wavefront explains."},
    {"frames_published", "Frames published."},
    {"spots_lost", "Spots not found, summed over all frames."},
    {"acquisitions", "Searches for spots in the whole image."},
    {"messages_dropped", "Stream messages dropped because a queue of the daemon was full."},
    {"deadline_missed", "Frames published more than one frame period after their arrival."},
    {"camera_reconnects", "Reconnections of the camera."},
    {"display_faults", "Faults of the display."},
    {"requests", "Requests on the control socket."},
    {"requests_refused", "Requests that were refused."},
    {"clients_rejected", "Connection attempts without a known key."},
}};

}  // namespace

std::string_view counter_help(std::string_view counter) {
  for (const auto& [name, help] : kCounters) {
    if (name == counter) return help;
  }
  return {};
}

}  // namespace ovws::metrics
