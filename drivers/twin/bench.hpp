/// The bench as it is now: what the SLM shows, the truth, the camera's window, and the light that
/// follows from them. The far field is computed in one thread, off the camera's.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

#include "core/base/image.hpp"
#include "core/port/camera.hpp"
#include "drivers/twin/bench_model.hpp"
#include "drivers/twin/twin_config.hpp"

namespace ovws::twin {

/// The light on the camera for one state of the bench. Immutable.
struct Scene {
  std::shared_ptr<const Image<float>> intensity;  ///< as BenchModel::intensity
  Truth truth;
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

  explicit Bench(const Config& config);

  void work(const std::stop_token& stop);  ///< body of the bench's thread

  void show(const Image<std::uint8_t>& grey);  ///< requires the SLM's size
  void go_dark();                              ///< the SLM is off: flat, every grey level 0

  Truth truth() const;
  void set_truth(const Truth& truth);

  /// The light in this window of the sensor, for the display and the truth as they are at the
  /// return: waits until nothing has changed since the far field was computed. Null if that is not
  /// so by the deadline, or on stop.
  std::shared_ptr<const Scene> scene(const Roi& window, Deadline deadline,
                                     const std::stop_token& stop);
  BenchStatus status() const;

 private:
  /// What a far field is computed from.
  struct State {
    std::shared_ptr<const Image<std::uint8_t>> grey;
    Truth truth;
    std::optional<Roi> window;
    std::uint64_t number = 0;  ///< counts the changes
  };
  std::shared_ptr<const Scene> compute(const State& now);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  State state_;
  std::shared_ptr<const Scene> scene_;
  std::uint64_t computed_ = 0;  ///< the State::number that scene_ shows
  BenchStatus status_;

  // The bench's thread only.
  BenchModel model_;
  State last_;
  std::shared_ptr<const Image<float>> last_intensity_;
};

}  // namespace ovws::twin
