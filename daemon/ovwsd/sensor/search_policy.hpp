/// When the whole image is searched for spots that frames lack.
#pragma once

#include <cstdint>

namespace ovws {

/// What the newest frames lack.
enum class Doubt {
  none,     ///< nothing: every spot is found, and a wavefront explains where they are
  partial,  ///< frames are valid, but lack a spot or are barely explained
  blind,    ///< no frame is valid
};

/// Exponential back-off that starts again whenever the image changes. Blind, a changed image is
/// searched at once; otherwise at most every kCalmPauseNs. An image that stays the same is searched
/// after pauses that double from kFirstPauseNs to kMaxPauseNs: the frames' noise differs. Times are
/// CLOCK_MONOTONIC. For one thread.
class SearchPolicy {
 public:
  static constexpr std::int64_t kFirstPauseNs = 200'000'000;
  static constexpr std::int64_t kCalmPauseNs = 500'000'000;
  static constexpr std::int64_t kMaxPauseNs = 30'000'000'000;

  /// Frames lack something. `changed`: the image differs from the one that was searched last.
  bool is_due(Doubt doubt, bool changed, std::int64_t now_ns) const;
  /// A search began, of an image that had changed or not.
  void begin(bool changed);
  /// It ended.
  void end(std::int64_t now_ns);
  /// Frames lack nothing: the next doubt is searched at once.
  void reset() { *this = {}; }

  /// Searches of the same image so far.
  int tries() const { return tries_; }
  /// When the same image is searched again.
  std::int64_t next_ns() const { return next_ns_; }

 private:
  int tries_ = 0;
  std::int64_t pause_ns_ = kFirstPauseNs;
  std::int64_t ended_ns_ = 0;
  std::int64_t next_ns_ = 0;
};

}  // namespace ovws
