/// The interface of procedures to the bench: show a hologram, wait until it has settled, measure
/// frames.
#pragma once

#include <atomic>
#include <functional>
#include <future>
#include <limits>
#include <optional>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/frames/frame_broker.hpp"
#include "daemon/ovwsd/frames/frame_series.hpp"
#include "daemon/ovwsd/procedures/pending_files.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/reference_image.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"

namespace ovws {

struct BenchDeps {
  SensorKeeper& keeper;
  CameraActor& camera;
  FrameBroker& frames;
  SlmLoop& slm;
  Jobs& jobs;
  Events& events;
};

/// Used by the thread of one procedure. Calls block until their result is there. They fail once the
/// job is cancelled or the daemon stops; the procedure must then return at once. Whatever it showed
/// is restored when it ends, also after an error.
class Bench {
 public:
  /// `stop` and `progress` must outlive the Bench.
  Bench(int job, const BenchDeps& deps, const std::atomic<bool>& stop,
        std::atomic<double>& progress);

  /// The current state.
  SensorView sensor() const { return deps_.keeper.snapshot(); }
  CameraSnapshot camera() const { return deps_.camera.snapshot(); }

  /// Shows the sensor with these modes (RMS-normalised waves) in place of the introduced
  /// aberration.
  Result<void> show(const std::vector<Mode>& aberration);
  /// The same with changed sensor settings, which are restored when the procedure ends.
  Result<void> show(const SensorSet& sensor, const std::vector<Mode>& aberration);
  /// Shows the image that `paint` draws. `paint` is called once, in the prepare thread. If the job
  /// is cancelled, that may be after this call has returned, so it must capture by value.
  Result<void> show(const Painter& paint);
  /// Activates the procedure's result and stores it. Returns when it is active and its file has
  /// been written, or the disk has not answered for two seconds.
  Result<void> use(SensorChange change);
  /// Files whose writing has not finished; the job ends when none is left.
  std::shared_ptr<PendingFiles> pending_files() const { return files_; }
  /// Publishes a warning event.
  void warn(std::string kind, std::string text, nlohmann::json data);

  /// Sets the gain and returns the value read back. The previous gain is restored when the
  /// procedure ends. Waits for a disconnected camera as long as for a frame.
  Result<double> set_gain(double gain_db);

  /// Records the next `frames` settled frames of the current hologram at the current gain. For
  /// `from` see FrameSeries.
  Result<std::vector<SeriesFrame>> series(int frames, FromPixels from = {});
  /// Called periodically while frames are awaited; an error ends the wait.
  using Check = std::function<Result<void>(const FrameBroker::Request&)>;
  /// Averages the spots of the next `frames` settled frames of the current hologram.
  Result<SpotAverage> spots(int frames, const Check& check = nullptr);
  /// The same with the mean image of some of these frames; reports the progress. Errc::refused,
  /// field "camera": the camera's settings changed during the job.
  Result<TakenReference> reference(int frames);
  /// The mean image of the next `frames` frames of the current hologram; NaN where a frame was
  /// saturated.
  Result<Image<float>> picture(int frames);

  /// Hands every frame with its pixels to `take` while the request lives, settled or not.
  [[nodiscard]] std::unique_ptr<FrameBroker::Request> watch(FrameBroker::Take take) {
    return deps_.frames.request(FrameBroker::Needs::pixels, std::numeric_limits<int>::max(),
                                std::move(take));
  }
  /// Waits for at least `min_ms`, and until `frames` more frames have been used.
  Result<void> wait_watching(const FrameBroker::Request& watch, double min_ms, int frames);
  /// Fails if the display was lost after it presented the current hologram at that time.
  Result<void> check_shown(std::int64_t presented_mono_ns) const;
  /// When the display presented the current hologram, CLOCK_MONOTONIC ns.
  std::int64_t presented_mono_ns() const { return deps_.slm.snapshot().t_presented_mono_ns; }

  /// Reports the progress of the whole procedure, 0 .. 1.
  void report_progress(double progress);
  /// Procedure thread, after the procedure: restores the gain. Returns when that is done, or when
  /// the camera thread has ended.
  void restore_gain();
  bool stopped() const { return stop_.load(); }

 private:
  template <class T>
  Result<T> wait_for(std::future<Result<T>> future);
  Result<double> try_gain(double gain_db);
  Result<void> check_display() const;
  Error no_frame(double waited_s) const;
  Result<void> edit(SensorChange change);
  std::unique_ptr<FrameBroker::Request> request_images(int frames, ImageMean& to) const;
  Result<void> wait_for(const FrameBroker::Request& request, const Check& check = nullptr) const;

  int job_;
  BenchDeps deps_;
  const std::atomic<bool>& stop_;
  std::atomic<double>& progress_;
  std::optional<double> gain_before_db_;  ///< none: the gain was not changed
  std::shared_ptr<PendingFiles> files_ = std::make_shared<PendingFiles>();
};

}  // namespace ovws
