/// Faults and events of the frame path, as counters: one enum names them all. Once all frames on
/// their way have arrived, grabbed = unplanned + unexpected + dropped + published.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string_view>

namespace ovws {

enum class Counter : std::uint8_t {
  frames_grabbed,       ///< complete frames taken from the camera
  frames_lost,          ///< gaps in the camera's frame numbers, incomplete frames not counted again
  frames_incomplete,    ///< delivered with missing packets, not tracked
  frames_duplicated,    ///< delivered a second time, not tracked
  frames_out_of_order,  ///< delivered after a later one, not tracked; counted as lost, too
  frames_late,          ///< arrived later than the transfer may take, published unsettled
  frames_left_justified,  ///< whose 16-bit pixels were shifted to where their format has them
  frames_unplanned,       ///< there was no plan to measure them with
  frames_unexpected,      ///< size or format is not the plan's, not tracked
  frames_dropped,         ///< no free record, or the publisher holds too many: somebody was behind
  frames_unsettled,       ///< published with settled = false
  frames_invalid,         ///< published with valid = false
  frames_unexplained,  ///< of the invalid, those refused because no wavefront explains their spots
  frames_published,    ///< left the pipeline
  spots_lost,          ///< sum over frames of subapertures not found
  acquisitions,        ///< whole-image searches
  messages_dropped,    ///< a stream's queue was full in this daemon
  deadline_missed,     ///< frames that took longer than one frame period from grab to publish ring
  camera_reconnects,
  display_faults,
  requests,
  requests_refused,
  clients_rejected,  ///< connections not let in, and requests of clients whose key was withdrawn
  count_,
};

std::string_view counter_name(Counter counter);

/// Thread-safe, RT-safe, relaxed.
class Counters {
 public:
  void add(Counter counter, std::uint64_t n = 1) {
    values_[std::size_t(counter)].fetch_add(n, std::memory_order_relaxed);
  }
  std::uint64_t get(Counter counter) const {
    return values_[std::size_t(counter)].load(std::memory_order_relaxed);
  }

 private:
  std::array<std::atomic<std::uint64_t>, std::size_t(Counter::count_)> values_{};
};

}  // namespace ovws
