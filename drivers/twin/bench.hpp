/// State of the simulated bench: the SLM's image, the ground truth, the camera's window, and the
/// far field that follows from them. The far field is computed in a thread of its own.
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
#include "drivers/twin/bench_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// Intensity on the camera for one state of the bench. Immutable.
struct Scene {
  std::shared_ptr<const Image<float>> intensity;  ///< as BenchModel::intensity
  Truth truth;
  std::int64_t t_ns = 0;           ///< time of the turbulence, UTC
  Turbulence::Modes turbulence{};  ///< modes at t_ns; zeros without turbulence
};

/// Ground truth of a frame that was sent.
struct FrameTruth {
  std::uint64_t frame_id = 0;
  std::int64_t t_ns = 0;
  Turbulence::Modes turbulence{};
};

struct BenchStatus {
  std::uint64_t changes = 0;     ///< of display, truth and window
  std::uint64_t far_fields = 0;  ///< number computed so far
  double far_field_ms = 0.0;     ///< computing time of the last one
};

/// Thread-safe.
class Bench {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// Longest time after a display change in which a frame of the previous image may still be sent.
  /// Without it, no frame could be sent while the display changes faster than far fields are
  /// computed. It is shorter than the daemon's settle_ms, with a margin for delivery and for the
  /// delay in noticing a change: the daemon never takes such a frame for a settled one.
  static constexpr auto kStaleFrameTime = std::chrono::milliseconds(10);

  explicit Bench(const Config& config);

  void work(const std::stop_token& stop);  ///< body of the bench's thread

  /// The display shows a new image of the SLM's size. `since`: not later than its first appearance.
  void show(const Image<std::uint8_t>& grey, Deadline since);
  void go_dark();  ///< the SLM is off: flat, every grey level 0

  Truth truth() const;
  std::shared_ptr<const Image<std::uint8_t>> shown() const;  ///< grey levels of the SLM
  void set_truth(const Truth& truth);

  /// Begins a frame of this window of the sensor at `t_ns` UTC. Returns the number of the current
  /// state; with turbulence every moment is a new state.
  std::uint64_t begin(const Roi& window, std::int64_t t_ns = 0);
  /// Waits for the scene of a frame that was begun in state `begun`: of that state or a newer one.
  /// A returned scene other than `ready` is to be prepared as a frame and passed as `ready` in the
  /// next call. Returns `ready` itself once that frame may be sent. Null at the deadline or on
  /// stop.
  std::shared_ptr<const Scene> scene(std::uint64_t begun, const std::shared_ptr<const Scene>& ready,
                                     Deadline deadline, const std::stop_token& stop);
  /// Notes a sent frame; with turbulence it is added to `frame_truths`.
  void note_sent(std::uint64_t frame_id, const Scene& scene);
  std::vector<FrameTruth> frame_truths() const;  ///< the last 32, the oldest first
  BenchStatus status() const;

 private:
  /// Inputs of a far field.
  struct State {
    std::shared_ptr<const Image<std::uint8_t>> grey;
    Truth truth;
    std::optional<Roi> window;
    std::int64_t t_ns = 0;
    std::uint64_t number = 0;  ///< counts the changes
  };
  std::shared_ptr<const Scene> compute(const State& now);
  bool update_turbulence(const State& now);
  void note_change();        // call with mutex_ locked
  void show_due_images();    // call with mutex_ locked: shows images that are due
  bool may_be_sent() const;  // call with mutex_ locked

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  State state_;
  std::shared_ptr<const Scene> scene_;
  std::uint64_t computed_ = 0;  ///< the State::number that scene_ shows
  std::uint64_t ordered_ = 0;   ///< State::number of the newest change of truth or window
  struct PendingImage {
    std::shared_ptr<const Image<std::uint8_t>> grey;
    Deadline due;
  };
  std::deque<PendingImage> pending_;  ///< on the display, but not yet on the liquid crystal
  std::chrono::steady_clock::duration settle_{};
  Deadline shown_since_;  ///< when state_.grey appeared on the SLM
  BenchStatus status_;
  std::deque<FrameTruth> frame_truths_;

  // The bench's thread only.
  BenchModel model_;
  State last_;
  std::optional<Turbulence> turbulence_;
  std::shared_ptr<const Image<float>> last_intensity_;
};

}  // namespace ovws::twin
