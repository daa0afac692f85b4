/// Names of the counters in `status` messages.
#include "core/rt/counters.hpp"

namespace ovws {

std::string_view counter_name(Counter counter) {
  switch (counter) {
    case Counter::frames_grabbed:
      return "frames_grabbed";
    case Counter::frames_lost:
      return "frames_lost";
    case Counter::frames_incomplete:
      return "frames_incomplete";
    case Counter::frames_duplicated:
      return "frames_duplicated";
    case Counter::frames_out_of_order:
      return "frames_out_of_order";
    case Counter::frames_late:
      return "frames_late";
    case Counter::frames_left_justified:
      return "frames_left_justified";
    case Counter::frames_unplanned:
      return "frames_unplanned";
    case Counter::frames_unexpected:
      return "frames_unexpected";
    case Counter::frames_dropped:
      return "frames_dropped";
    case Counter::frames_unsettled:
      return "frames_unsettled";
    case Counter::frames_invalid:
      return "frames_invalid";
    case Counter::frames_unexplained:
      return "frames_unexplained";
    case Counter::frames_published:
      return "frames_published";
    case Counter::spots_lost:
      return "spots_lost";
    case Counter::acquisitions:
      return "acquisitions";
    case Counter::messages_dropped:
      return "messages_dropped";
    case Counter::deadline_missed:
      return "deadline_missed";
    case Counter::camera_reconnects:
      return "camera_reconnects";
    case Counter::display_faults:
      return "display_faults";
    case Counter::requests:
      return "requests";
    case Counter::requests_refused:
      return "requests_refused";
    case Counter::clients_rejected:
      return "clients_rejected";
    case Counter::count_:
      break;
  }
  return "unknown";
}

}  // namespace ovws
