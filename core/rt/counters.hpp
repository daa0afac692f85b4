/// Event and fault counters of the daemon, named in one enum. When no frame is in flight,
/// frames_grabbed = frames_unplanned + frames_unexpected + frames_dropped + frames_published.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <string_view>

namespace ovws {

enum class Counter : std::uint8_t {
  frames_grabbed,         ///< complete frames taken from the camera
  frames_lost,            ///< missing frame numbers, not counting incomplete frames
  frames_incomplete,      ///< frames with missing packets; not measured
  frames_duplicated,      ///< frames delivered a second time; not measured
  frames_out_of_order,    ///< frames delivered after a later frame; not measured, counted as lost
  frames_late,            ///< frames later than the transfer time allows; not settled
  frames_left_justified,  ///< frames with MSB-aligned 16-bit pixels, which are shifted right
  frames_unplanned,       ///< frames that arrived while no measurement plan was active
  frames_unexpected,      ///< image size or pixel format differs from the plan's; not measured
  frames_dropped,         ///< discarded: no free frame record, or too many held by the publisher
  frames_unsettled,       ///< frames with settled = false
  frames_invalid,         ///< published with valid = false
  frames_unexplained,     ///< invalid: no wavefront explains the spots, or none is confirmed
  frames_published,       ///< handed to the publisher
  spots_lost,             ///< subapertures whose spot was not found, summed over frames
  acquisitions,           ///< searches of the whole image for the spots
  messages_dropped,       ///< discarded because the send queue of a stream was full
  deadline_missed,  ///< frames that took longer than one frame period from grab to publish ring
  camera_reconnects,
  display_faults,
  requests,
  requests_refused,
  clients_rejected,  ///< refused connections, and requests of clients whose key was revoked
  count_,
};

struct CounterRow {
  std::string_view name;  ///< as in `status` messages
  std::string_view help;  ///< a sentence
  bool is_loss = false;   ///< something is missing, late or wrong
};
/// All counters, in the order of the enum, which is that in which people read them.
std::span<const CounterRow> all_counters();
std::string_view counter_name(Counter counter);

/// Set of counters. Thread-safe and RT-safe; uses relaxed atomics, so counters are not ordered.
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
