#include "core/rt/counters.hpp"

namespace ovws {
namespace {

constexpr auto kNames = std::to_array<std::string_view>(
    {"frames_grabbed",        "frames_lost",         "frames_incomplete",
     "frames_duplicated",     "frames_out_of_order", "frames_late",
     "frames_left_justified", "frames_unplanned",    "frames_unexpected",
     "frames_dropped",        "frames_unsettled",    "frames_invalid",
     "frames_unexplained",    "frames_published",    "spots_lost",
     "acquisitions",          "messages_dropped",    "deadline_missed",
     "camera_reconnects",     "display_faults",      "requests",
     "requests_refused",      "clients_rejected"});
static_assert(kNames.size() == std::size_t(Counter::count_));

}  // namespace

std::span<const std::string_view> all_counter_names() {
  return kNames;
}

std::string_view counter_name(Counter counter) {
  return kNames[std::size_t(counter)];
}

}  // namespace ovws
