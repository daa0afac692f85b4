/// Event and fault counters of the frame path, named in one enum. Once all frames in flight have
/// arrived, grabbed = unplanned + unexpected + dropped + published.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <string_view>

namespace ovws {

enum class Counter : std::uint8_t {
  frames_grabbed,         ///< complete frames taken from the camera
  frames_lost,            ///< gaps in the camera's frame numbers, without the incomplete frames
  frames_incomplete,      ///< delivered with missing packets, not tracked
  frames_duplicated,      ///< delivered a second time, not tracked
  frames_out_of_order,    ///< delivered after a later one, not tracked; also counted as lost
  frames_late,            ///< arrived later than the transfer time allows, published unsettled
  frames_left_justified,  ///< MSB-aligned 16-bit pixels, shifted right
  frames_unplanned,       ///< no measurement plan was active
  frames_unexpected,      ///< image size or pixel format differs from the plan's, not tracked
  frames_dropped,         ///< no free record, or the publisher held too many
  frames_unsettled,       ///< published with settled = false
  frames_invalid,         ///< published with valid = false
  frames_unexplained,     ///< part of the invalid: no wavefront explains their spots
  frames_published,       ///< handed to the publisher
  spots_lost,             ///< sum over frames of subapertures not found
  acquisitions,           ///< whole-image searches
  messages_dropped,       ///< the daemon's send queue of a stream was full
  deadline_missed,  ///< frames that took longer than one frame period from grab to publish ring
  camera_reconnects,
  display_faults,
  requests,
  requests_refused,
  clients_rejected,  ///< refused connections, and requests of clients whose key was revoked
  count_,
};

/// The names in `status` messages, in the order of the enumeration.
std::span<const std::string_view> all_counter_names();
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
