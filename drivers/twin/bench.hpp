/// State of the simulated bench: the SLM's image, the ground truth and the camera's window. A
/// separate thread computes the far field from this state.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/base/image.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/optical_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Light of one pattern.
struct PatternLight {
  std::shared_ptr<const Image<float>> intensity;  ///< result of OpticalModel::intensity
  std::uint32_t crc32 = 0;  ///< of the grey levels that the modulator shows, row by row
};

/// Intensity on the camera for one state of the bench. Immutable.
struct Scene {
  /// Of each pattern of one display image; video mode has one. With turbulence only what the frame
  /// exposes is there.
  std::vector<PatternLight> patterns;
  Truth truth;
  std::int64_t t_ns = 0;           ///< time at which the turbulence is evaluated, UTC
  Turbulence::Modes turbulence{};  ///< Zernike modes of the turbulence at t_ns; zeros without it
  std::uint64_t number = 0;        ///< of the state
};

/// Ground truth of a sent frame: the modulator's image and the turbulence in it.
struct FrameTruth {
  std::uint64_t frame_id = 0;  ///< on the wire: 1 to 65535, then 1 again
  std::int64_t t_ns = 0;       ///< device timestamp, UTC
  /// Of the grey levels that the modulator had turned to, row by row; of the first pattern.
  std::uint32_t crc32 = 0;
  std::optional<int> pattern;  ///< none in video mode, and if the frame shows several patterns
  Turbulence::Modes turbulence{};
};

struct BenchStatus {
  std::uint64_t changes = 0;     ///< changes of display, truth, window and turbulence time
  std::uint64_t far_fields = 0;  ///< far fields computed so far
  double far_field_ms = 0.0;     ///< computing time of the last far field
};

/// The simulated bench. Thread-safe.
class Bench {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// Longest time after a display change in which a frame of the previous image may still be sent.
  /// Without this allowance, the camera would send nothing while the display changes faster than
  /// far fields are computed. The time is shorter than the daemon's settle_ms, with a margin for
  /// delivery and for detecting the change, so the daemon never accepts a stale frame as settled.
  static constexpr auto kStaleFrameTime = std::chrono::milliseconds(4);

  /// How long an image is kept for frames that begin late, while no frame begins.
  static constexpr auto kKeptImageTime = std::chrono::milliseconds(100);

  /// Longest time by which the moment of a frame's turbulence is before the frame's begin.
  static constexpr std::int64_t kEarlyMomentNs = 500'000;

  explicit Bench(const Config& config);

  void work(const std::stop_token& stop);  ///< body of the bench's thread

  /// Reports a new display image. `since`: a time not later than the first appearance of the image.
  /// In pattern mode it takes effect at the begin of the next cycle, all patterns at once.
  void show(const Patterns& patterns, Deadline since);
  void go_dark();  ///< switches the modulator off: every grey level becomes 0

  Truth truth() const;
  std::shared_ptr<const Patterns> shown() const;  ///< newest display image, settled or not
  const std::optional<PatternClock>& clock() const { return clock_; }  ///< none in video mode
  void set_truth(const Truth& truth);
  /// Sets Light::mirror_waves. Unlike other changes, this does not withdraw a frame that has begun.
  void set_mirror(const std::vector<double>& waves);

  /// Begins a frame of this window of the sensor at `t_ns` UTC. Returns the number of the current
  /// state; with turbulence every moment is a new state. `period_ns`: time from frame to frame. If
  /// it is not 0, the next moment is computed ahead after `note_sent`. For a frame that begins when
  /// expected, Scene::t_ns is up to kEarlyMomentNs before `t_ns`, else equal to it. `exposed`: what
  /// the frame shows.
  std::uint64_t begin(const Roi& window, std::int64_t t_ns = 0, std::int64_t period_ns = 0,
                      const Exposed& exposed = {});
  /// Waits for a scene of state `begun` (returned by `begin`) or of a newer state. If the returned
  /// scene is not `ready`, the caller prepares a frame of it and passes the scene as `ready` in the
  /// next call. Returns `ready` itself once its frame may be sent. Null at the deadline or on stop.
  std::shared_ptr<const Scene> scene(std::uint64_t begun, const std::shared_ptr<const Scene>& ready,
                                     Deadline deadline, const std::stop_token& stop);
  /// Records a sent frame, the one begun last: adds its ground truth to `frame_truths`.
  void note_sent(std::uint64_t frame_id, std::int64_t t_device_ns, const Scene& scene);
  /// Of the last 32 frames, oldest first. Or of the first 2048 after the frame number `after`, as
  /// far as they are among the last 16384.
  std::vector<FrameTruth> frame_truths(std::optional<int> after = {}) const;
  BenchStatus status() const;
  /// The optical model, for the functions that any thread may call.
  const OpticalModel& optics() const { return *model_; }

 private:
  /// Inputs of a far field.
  struct State {
    std::shared_ptr<const Patterns> shown;
    Truth truth;
    std::optional<Roi> window;
    std::int64_t t_ns = 0;
    Exposed exposed;           ///< of the newest frame
    std::uint64_t number = 0;  ///< increases with each change of the state
  };
  std::shared_ptr<const Scene> compute(const State& now);
  void compute_light(const State& now);
  std::shared_ptr<const Scene> compute_unlocked(const State& now,
                                                std::unique_lock<std::mutex>& lock);
  void compute_now(std::unique_lock<std::mutex>& lock);
  void prepare_next(std::unique_lock<std::mutex>& lock);
  void compute_ahead(std::unique_lock<std::mutex>& lock);
  bool update_turbulence(const State& now);
  bool takes_effect_at_once() const { return settle_.count() == 0 && !clock_; }
  Deadline effect_of(Deadline since) const;
  void expect_next();                                  // call with mutex_ locked
  std::shared_ptr<const Patterns> next_shown() const;  // call with mutex_ locked
  bool preparation_wanted() const;                     // call with mutex_ locked
  bool ahead_wanted() const;          // call with mutex_ locked, in the bench's thread
  void note_change();                 // call with mutex_ locked
  void show_due_images(Deadline at);  // call with mutex_ locked: shows images that have settled
  bool may_be_sent() const;           // call with mutex_ locked
  bool unchanged_but_mirror(const Scene* scene, std::uint64_t begun) const;  // with mutex_ locked

  const std::optional<PatternClock> clock_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  State state_;
  std::shared_ptr<const Scene> scene_;
  std::uint64_t computed_ = 0;  ///< State::number from which scene_ was computed
  /// State::number of the newest change of truth, window or turbulence time.
  std::uint64_t ordered_ = 0;
  std::uint64_t before_mirror_ = 0;  ///< State::number of the newest change but the mirror's
  struct PendingImage {
    std::shared_ptr<const Patterns> patterns;
    Deadline due;
  };
  std::deque<PendingImage> pending_;          ///< on the display, but not yet on the liquid crystal
  std::shared_ptr<const Patterns> prepared_;  ///< the last image that was prepared
  std::chrono::steady_clock::duration settle_{};
  Deadline appeared_;                          ///< when state_.shown appeared on the display
  std::int64_t begun_ns_ = 0, period_ns_ = 0;  ///< of the newest frame
  Deadline begun_;                             ///< when `begin` was called for it
  std::int64_t next_ns_ = 0;  ///< expected moment of the next frame; 0: none is expected
  Deadline next_begin_;       ///< when that frame is expected to begin
  BenchStatus status_;
  std::deque<FrameTruth> frame_truths_;

  // Used by the bench's thread (`work`) only.
  const std::unique_ptr<OpticalModel> model_;
  State last_;
  std::optional<Turbulence> turbulence_;
  std::vector<PatternLight> last_light_;  ///< of last_; intensity is null where it was not needed
  std::uint64_t computed_light_ = 0;      ///< how many intensities were computed so far
};

}  // namespace ovws::twin
