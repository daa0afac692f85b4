/// Search policy: decides when to search the wavefront again, and when to render new templates. How
/// long a search goes on is decided in wavefront_search.cpp.
#pragma once

#include <cstdint>

namespace ovws {

/// How well the newest frames are measured.
enum class Doubt {
  none,     ///< templates describe the frames
  partial,  ///< frames are valid, but new templates would measure better
  blind,    ///< no frame is valid
};

/// How well the active templates measure a frame.
struct TemplateDrift {
  double drift_waves = 0.0;     ///< RMS change of all modes since the templates were rendered
  double sigma_waves = 0.0;     ///< standard error of drift_waves by noise
  double residual = 0.0;        ///< RMS residual of the fit of the modes, standard errors
  double point_residual = 0.0;  ///< residual of the image for which the templates were rendered
  bool in_air = false;          ///< the templates allow for modes above the measured ones
};

/// Whether new templates about the frame's wavefront would measure it better. Without `in_air`: if
/// it drifted by more than noise and 0.02 wave, or 0.002 wave if the fit leaves more than noise.
/// `in_air`: also if the fit leaves more than noise, or less than the air that the templates allow
/// for, or at any drift above 0.05 wave.
bool is_drifted(const TemplateDrift& frame);

/// Exponential backoff that restarts whenever the image changes. A changed image is searched at
/// once if the doubt is `blind`, and at most every kCalmPauseNs if it is `partial`. An unchanged
/// image is searched again after pauses that double from kFirstPauseNs to kMaxPauseNs: another
/// frame has other noise, so the search may succeed. Times are CLOCK_MONOTONIC. For one thread.
class SearchPolicy {
 public:
  static constexpr std::int64_t kFirstPauseNs = 200'000'000;
  static constexpr std::int64_t kCalmPauseNs = 500'000'000;
  static constexpr std::int64_t kMaxPauseNs = 30'000'000'000;

  /// Whether to search now. `changed`: the image differs from the one searched last.
  bool is_due(Doubt doubt, bool changed, std::int64_t now_ns) const;
  /// Call when a search begins. If the image has changed (as for is_due), restarts the backoff.
  void begin(bool changed);
  /// Call when a search has failed. Sets the pause before the next search.
  void end(std::int64_t now_ns);
  /// Call when templates describe the frames again. Ends the backoff, so that the next doubt starts
  /// a search at once.
  void reset() { *this = {}; }

  /// Number of searches of the unchanged image so far.
  int tries() const { return tries_; }
  /// Time from which the unchanged image may be searched again.
  std::int64_t next_ns() const { return next_ns_; }

 private:
  int tries_ = 0;
  std::int64_t pause_ns_ = kFirstPauseNs;
  std::int64_t ended_ns_ = 0;
  std::int64_t next_ns_ = 0;
};

/// Decides when spot positions count instead of templates: when searches have failed for kAfterNs,
/// and positions explain most frames, as in air. They no longer count when they explain less than a
/// quarter: then there are hardly any frames to win, and the next wavefront might be measured
/// wrong. For one thread.
class GivingUp {
 public:
  static constexpr std::int64_t kAfterNs = 3'000'000'000;

  /// Call when a search has failed, which began at `began_ns`: whether positions shall count.
  /// `given_up`: whether they do. `frames`: number of frames without templates since the last
  /// failure; `explained`: those of them that positions explain. Times are CLOCK_MONOTONIC.
  bool failed(bool given_up, std::int64_t began_ns, std::int64_t now_ns, int frames, int explained);
  /// Call when searches no longer fail, while a job holds the sensor, and for another sensor.
  void reset() { failing_since_ns_ = 0; }

 private:
  std::int64_t failing_since_ns_ = 0;  ///< 0: not failing
};

}  // namespace ovws
