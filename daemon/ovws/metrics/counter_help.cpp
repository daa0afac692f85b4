/// Help text of each counter in `status.counters`.
#include <array>
#include <utility>

#include "daemon/ovws/metrics/families.hpp"

namespace ovws::metrics {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 23> kCounters{{
    {"frames_grabbed", "Complete frames taken from the camera in order."},
    {"frames_lost", "Frame numbers that the camera left out."},
    {"frames_incomplete", "Frames that arrived with packets missing."},
    {"frames_duplicated", "Frames that came a second time."},
    {"frames_out_of_order", "Frames that came after a later one."},
    {"frames_late", "Frames that came too late to be acted on."},
    {"frames_left_justified", "Frames whose numbers filled their 16 bits from the left."},
    {"frames_unplanned", "Frames that there was nothing to measure with."},
    {"frames_unexpected", "Frames of another size or format than they are measured with."},
    {"frames_dropped", "Frames left out because the daemon was behind."},
    {"frames_unsettled", "Frames published while the hologram was changing."},
    {"frames_invalid", "Frames published without a wavefront that can be stood behind."},
    {"frames_unexplained", "Invalid frames whose spots no wavefront explains."},
    {"frames_published", "Frames that left the pipeline."},
    {"spots_lost", "Subapertures not found, over all frames."},
    {"acquisitions", "Searches for spots in the whole image."},
    {"messages_dropped", "Stream messages for which a queue of the daemon was full."},
    {"deadline_missed", "Frames that took longer than their period from their arrival on."},
    {"camera_reconnects", "How often the camera was opened again."},
    {"display_faults", "How often the display failed."},
    {"requests", "Requests on the control socket."},
    {"requests_refused", "Requests that were refused."},
    {"clients_rejected", "Attempts to come in without a key that is known."},
}};

}  // namespace

std::string_view counter_help(std::string_view counter) {
  for (const auto& [name, help] : kCounters) {
    if (name == counter) return help;
  }
  return {};
}

}  // namespace ovws::metrics
