/// Names of the counters that count losses, in the order in which people read them.
#pragma once

#include <array>
#include <string_view>

namespace ovws::cli {

inline constexpr std::array<std::string_view, 14> kLosses{
    "frames_lost",        "frames_incomplete", "frames_duplicated", "frames_out_of_order",
    "frames_late",        "frames_unplanned",  "frames_unexpected", "frames_dropped",
    "frames_unexplained", "spots_lost",        "messages_dropped",  "deadline_missed",
    "camera_reconnects",  "display_faults"};

}  // namespace ovws::cli
