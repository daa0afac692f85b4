/// Decides when to search the wavefront again.
#pragma once

#include <cstdint>

namespace ovws {

/// How well the newest frames are measured.
enum class Doubt {
  none,     ///< templates describe them
  partial,  ///< frames are valid, but templates would measure them better
  blind,    ///< no frame is valid
};

/// Exponential backoff that restarts whenever the image changes. While blind, a changed image is
/// searched at once; while partial, at most every kCalmPauseNs. An unchanged image is searched
/// again after pauses that double from kFirstPauseNs to kMaxPauseNs, because another frame has
/// other noise. Times are CLOCK_MONOTONIC. For one thread.
class SearchPolicy {
 public:
  static constexpr std::int64_t kFirstPauseNs = 200'000'000;
  static constexpr std::int64_t kCalmPauseNs = 500'000'000;
  static constexpr std::int64_t kMaxPauseNs = 30'000'000'000;

  /// Whether to search now. `changed`: the image differs from the one searched last.
  bool is_due(Doubt doubt, bool changed, std::int64_t now_ns) const;
  /// Call when a search begins. `changed`: as for is_due; restarts the backoff.
  void begin(bool changed);
  /// Call when the search has ended.
  void end(std::int64_t now_ns);
  /// Call when frames are good again. Ends the pauses: when they are bad next, a search is due at
  /// once.
  void reset() { *this = {}; }

  /// Searches of the unchanged image so far.
  int tries() const { return tries_; }
  /// When the unchanged image is searched again.
  std::int64_t next_ns() const { return next_ns_; }

 private:
  int tries_ = 0;
  std::int64_t pause_ns_ = kFirstPauseNs;
  std::int64_t ended_ns_ = 0;
  std::int64_t next_ns_ = 0;
};

}  // namespace ovws
