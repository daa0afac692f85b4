/// The bench as it is now: what the SLM shows, the truth, the camera's window, and the light that
/// follows from them. The far field is computed in one thread, off the camera's.
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

/// The light on the camera for one state of the bench. Immutable.
struct Scene {
  std::shared_ptr<const Image<float>> intensity;  ///< as BenchModel::intensity
  Truth truth;
  std::int64_t t_ns = 0;           ///< UTC: the moment of the turbulence
  Turbulence::Modes turbulence{};  ///< its modes then; zeros without turbulence
};

/// What was true of a frame that was sent.
struct FrameTruth {
  std::uint64_t frame_id = 0;
  std::int64_t t_ns = 0;
  Turbulence::Modes turbulence{};
};

struct BenchStatus {
  std::uint64_t changes = 0;     ///< of display, truth and window
  std::uint64_t far_fields = 0;  ///< computed
  double far_field_ms = 0.0;     ///< the last one took
};

/// Thread-safe.
class Bench {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  /// How long after a change of the display a frame from before it may be sent. Without this
  /// allowance no frame could be sent while the display changes faster than far fields are
  /// computed. It is less than the daemon's settle_ms by what delivery and the news of a change may
  /// take: the daemon then never takes such a frame for a settled one.
  static constexpr auto kTurning = std::chrono::milliseconds(10);

  explicit Bench(const Config& config);

  void work(const std::stop_token& stop);  ///< body of the bench's thread

  /// `since`: not later than the first moment at which the display showed this. Requires the SLM's
  /// size.
  void show(const Image<std::uint8_t>& grey, Deadline since);
  void go_dark();  ///< the SLM is off: flat, every grey level 0

  Truth truth() const;
  std::shared_ptr<const Image<std::uint8_t>> shown() const;  ///< grey levels of the SLM
  void set_truth(const Truth& truth);

  /// A frame of this window of the sensor begins now, `t_ns` UTC. Returns the number of the present
  /// state: with turbulence, a new one.
  std::uint64_t begin(const Roi& window, std::int64_t t_ns = 0);
  /// The light for a frame that was begun in state `begun`, of that state or of a newer one. A
  /// scene that is not `ready` yet is for preparing the frame: it becomes so, or a newer one does.
  /// Returns `ready` itself when a frame of it may be sent, which is decided anew after each
  /// preparation; null if nothing comes by the deadline, or on stop.
  std::shared_ptr<const Scene> scene(std::uint64_t begun, const std::shared_ptr<const Scene>& ready,
                                     Deadline deadline, const std::stop_token& stop);
  /// A frame was sent. With turbulence, `frame_truths` has it from now on.
  void note_sent(std::uint64_t frame_id, const Scene& scene);
  std::vector<FrameTruth> frame_truths() const;  ///< the last 32, the oldest first
  BenchStatus status() const;

 private:
  /// What a far field is computed from.
  struct State {
    std::shared_ptr<const Image<std::uint8_t>> grey;
    Truth truth;
    std::optional<Roi> window;
    std::int64_t t_ns = 0;
    std::uint64_t number = 0;  ///< counts the changes
  };
  std::shared_ptr<const Scene> compute(const State& now);
  bool move_air(const State& now);
  void note_change();        // call with mutex_ locked
  void turn_crystal();       // call with mutex_ locked: what is due
  bool may_be_sent() const;  // call with mutex_ locked

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  State state_;
  std::shared_ptr<const Scene> scene_;
  std::uint64_t computed_ = 0;  ///< the State::number that scene_ shows
  std::uint64_t ordered_ = 0;   ///< the newest change of truth or window
  struct Turning {
    std::shared_ptr<const Image<std::uint8_t>> grey;
    Deadline due;
  };
  std::deque<Turning> turning_;  ///< what the display shows and the liquid crystal not yet
  std::chrono::steady_clock::duration settle_{};
  Deadline shown_since_;  ///< when the display began to show what it shows
  BenchStatus status_;
  std::deque<FrameTruth> frame_truths_;

  // The bench's thread only.
  BenchModel model_;
  State last_;
  std::optional<Turbulence> turbulence_;
  std::shared_ptr<const Image<float>> last_intensity_;
};

}  // namespace ovws::twin
