/// Interface of the procedures to the bench: show a hologram, wait for the SLM to settle, measure
/// frames.
#pragma once

#include <functional>
#include <future>
#include <optional>
#include <utility>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "core/base/result.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/zernike.hpp"
#include "daemon/ovwsd/actor/jobs.hpp"
#include "daemon/ovwsd/camera/camera_actor.hpp"
#include "daemon/ovwsd/frames/frame_tap.hpp"
#include "daemon/ovwsd/frames/measured_under.hpp"
#include "daemon/ovwsd/library/reference.hpp"
#include "daemon/ovwsd/library/reference_image.hpp"
#include "daemon/ovwsd/sensor/sensor_keeper.hpp"
#include "daemon/ovwsd/sensor/spot_average.hpp"

namespace ovws {

struct BenchDeps {
  const Config& config;  ///< at the daemon's start
  SensorKeeper& keeper;
  CameraActor& camera;
  FrameTaps& frames;
  SlmLoop& slm;
  Jobs& jobs;
  Events& events;
};

/// End of a job: calls `then` when the last pointer to it is gone. Those that still write a file of
/// the job have one each.
struct JobEnd {
  JobEnd() = default;
  JobEnd(const JobEnd&) = delete;
  JobEnd& operator=(const JobEnd&) = delete;
  ~JobEnd() {
    if (then) then();
  }
  std::function<void()> then{};
};

/// Bench access for the thread of one procedure. Each call blocks until its result is available.
/// Calls fail once the job is cancelled or the daemon stops; the procedure must then return at
/// once. The previous hologram is restored when the procedure ends, also after an error.
class Bench {
 public:
  /// `live` of the job must outlive the Bench.
  Bench(int job, const BenchDeps& deps, Jobs::Live& live) : job_(job), deps_(deps), live_(live) {}

  /// Snapshot of the sensor's current state.
  SensorView sensor() const { return deps_.keeper.snapshot(); }
  CameraSnapshot camera() const { return deps_.camera.snapshot(); }
  const Config& config() const { return deps_.config; }
  const SlmGeometry& geometry() const { return deps_.config.slm.geometry; }

  /// Shows the sensor's hologram with the modes `aberration` (RMS-normalised waves) in place of the
  /// introduced aberration.
  Result<void> show(const std::vector<Mode>& aberration);
  /// Shows the modes (RMS-normalised waves) with changed sensor settings. The previous settings are
  /// restored when the procedure ends.
  Result<void> show(const SensorSet& sensor, const std::vector<Mode>& aberration);
  /// Shows the image that `paint` draws. `paint` is called once, in the prepare thread. If the job
  /// is cancelled, `paint` may be called after `show` has returned, so it must capture by value.
  Result<void> show(const Painter& paint);
  /// Waits until the SLM has settled to the hologram shown last; returns that time, CLOCK_MONOTONIC
  /// in ns.
  Result<std::int64_t> wait_settled() const;
  /// Activates the procedure's result and stores it. Returns when the result is active and its file
  /// is written. Waits two seconds at most for the disk, less if the job is cancelled meanwhile.
  /// After its last step, the default, the job cannot be cancelled any more.
  enum class Step { early, last };
  Result<void> use(SensorChange change, Step step = Step::last);
  /// The end of the job, kept by whatever still writes a file of it.
  std::shared_ptr<JobEnd> end() const { return end_; }
  /// Takes the end of the job, when the procedure has returned.
  std::shared_ptr<JobEnd> take_end() { return std::move(end_); }
  /// Publishes an event of severity info.
  void publish_info(std::string kind, std::string text, nlohmann::json data);
  /// Publishes a warning event.
  void warn(std::string kind, std::string text, nlohmann::json data);

  /// Changes exposure or gain of the camera and returns the state afterwards. The previous values
  /// are restored when the procedure ends, unless keep_camera is called. Waits for a disconnected
  /// camera for as long as for a frame, at least 10 s.
  Result<CameraSnapshot> set_camera(const CameraSet& change);
  /// Makes the camera's settings the job's result: they are not restored. Errc::refused: the job
  /// was cancelled.
  Result<void> keep_camera();

  /// Averages the spots of the next `frames` settled frames of the current hologram: those of the
  /// main light source, and into `beams`, if given, those of the further ones.
  Result<SpotAverage> spots(int frames, std::vector<SpotAverage>* beams = nullptr);
  /// Averages the spots of the next `frames` settled frames of the current hologram and camera
  /// settings, and the images of some of these frames. Reports the progress. Errc::refused, field
  /// "camera": the camera's settings changed during the job. `only`: see TakenReference.
  Result<TakenReference> reference(int frames, const std::string& only = {});
  /// Mean image of the next `frames` frames of the current hologram and camera settings, DN; NaN at
  /// pixels that were saturated in a frame.
  Result<Image<float>> picture(int frames);

  FrameTaps& frames() { return deps_.frames; }
  /// Passes every frame with its pixels to `take`, settled or not, until the tap is closed.
  [[nodiscard]] FrameTap watch(FrameTap::Take take) {
    return {deps_.frames, FrameTap::Needs::pixels, FrameTap::kEndless, std::move(take)};
  }
  /// Waits for at least `min_ms`, and until `watch` has used `frames` more frames.
  Result<void> wait_watching(const FrameTap& watch, double min_ms, int frames);
  /// Fails if the SLM's display was lost after it presented the hologram at `presented_mono_ns`.
  Result<void> check_shown(std::int64_t presented_mono_ns) const;
  /// Time at which the display presented the current hologram, CLOCK_MONOTONIC, ns.
  std::int64_t presented_mono_ns() const { return deps_.slm.snapshot().t_presented_mono_ns; }

  /// Reports the progress of the whole procedure, 0 .. 1, or of its part.
  void report_progress(double progress);
  /// Begins a part of the procedure: its progress 0 .. 1 is `begin` .. `begin + share` of the
  /// whole.
  void begin_part(double begin, double share) { part_ = {begin, share}; }
  /// Restores exposure and gain of the camera; call it in the procedure thread after the procedure.
  /// Returns when they are restored, or when the camera thread has ended.
  void restore_camera();
  bool stopped() const { return live_.stop.load(); }

 private:
  /// Check that is called periodically while a call waits for frames; an error ends the wait.
  using Check = std::function<Result<void>(const FrameTap&)>;

  template <class T>
  Result<T> wait_for(std::future<Result<T>> future);
  Result<CameraSnapshot> try_camera(const CameraSet& change);
  Result<void> check_display() const;
  Error no_frame(double waited_s) const;
  Result<void> edit(SensorChange change);
  FrameTap tap_images(const MeasuredUnder& under, int frames, ImageMean& to) const;
  Result<SpotAverage> spots(const SensorSnapshot& now, const MeasuredUnder& under, int frames,
                            const Check& check, std::vector<SpotAverage>* beams);
  Result<void> wait_for(FrameTap& tap, const Check& check = nullptr) const;

  int job_;
  BenchDeps deps_;
  Jobs::Live& live_;
  std::pair<double, double> part_{0.0, 1.0};  ///< begin and share of the part in progress
  CameraSet camera_before_;                   ///< settings to restore; empty: unchanged
  std::shared_ptr<JobEnd> end_ = std::make_shared<JobEnd>();
};

}  // namespace ovws
