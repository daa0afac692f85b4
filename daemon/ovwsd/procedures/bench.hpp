/// The bench in the hands of a procedure: show, wait until it stands, look.
#pragma once

#include <atomic>
#include <functional>
#include <future>
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
#include "daemon/ovwsd/frames/intensity.hpp"
#include "daemon/ovwsd/procedures/pending_files.hpp"
#include "daemon/ovwsd/sensor/reference.hpp"
#include "daemon/ovwsd/sensor/reference_picture.hpp"
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

/// For the thread of one procedure. Every call waits for what it promises, and fails once the job
/// was cancelled or the daemon ends; a procedure then returns at once. What it showed is taken back
/// when it ends, however it ends.
class Bench {
 public:
  /// `stop` and `progress` outlive it.
  Bench(int job, const BenchDeps& deps, const std::atomic<bool>& stop,
        std::atomic<double>& progress);

  /// As it is now.
  SensorView sensor() const { return deps_.keeper.snapshot(); }
  CameraSnapshot camera() const { return deps_.camera.snapshot(); }

  /// The sensor with these modes, RMS-normalised waves, in place of the aberration of before.
  Result<void> show(const std::vector<Mode>& aberration);
  /// The same, and what of the sensor is otherwise until the procedure ends.
  Result<void> show(const SensorSet& sensor, const std::vector<Mode>& aberration);
  /// What `paint` draws; it is called once, in the prepare thread, and after this has returned if
  /// the job is cancelled meanwhile: it holds copies.
  Result<void> show(const Painter& paint);
  /// What the procedure has measured comes into force, and is kept. Returns when it is in force,
  /// and its file is written or the disk has not answered for two seconds.
  Result<void> use(SensorChange change);
  /// Those that the disk has not answered for: the job ends when it has.
  std::shared_ptr<PendingFiles> pending_files() const { return files_; }
  /// A warning for a person.
  void warn(std::string kind, std::string text, nlohmann::json data);

  /// The gain as read back. What it was is put back when the procedure ends. A camera that is away
  /// is waited for as long as a frame is.
  Result<double> set_gain(double gain_db);

  /// The next `frames` settled frames of the sensor shown last, at the gain set last; `windows_px`
  /// as of FrameSeries.
  Result<std::vector<SeriesFrame>> series(int frames, std::vector<Vec2> windows_px = {});
  /// Of the next `frames` settled frames of the sensor shown last.
  Result<SpotAverage> spots(int frames);
  /// The same, and the mean image of some of the frames; reports the progress. Errc::refused, field
  /// "camera": its settings changed meanwhile.
  Result<TakenReference> reference(int frames);
  /// The mean image of the next `frames` frames of what was shown last. NaN where a frame was
  /// saturated.
  Result<Image<float>> picture(int frames);

  /// From now on the intensity at two places, of every frame that comes; see IntensityWatch.
  IntensityWatch watch(std::array<Vec2, 2> places_px, double radius_px) {
    return {deps_.frames, places_px, radius_px};
  }
  /// Waits for `min_ms`, and until `frames` more frames were watched.
  Result<void> watch_on(const IntensityWatch& watch, double min_ms, int frames);
  /// Errors: the display was lost since it took, at that time, what was shown last.
  Result<void> check_shown(std::int64_t presented_mono_ns) const;
  /// When the display took what was shown last, CLOCK_MONOTONIC ns.
  std::int64_t presented_mono_ns() const { return deps_.slm.snapshot().t_presented_mono_ns; }

  /// 0 .. 1, of the whole procedure.
  void tell(double progress);
  /// Procedure thread, when the procedure has ended: returns when the gain is what it was, or the
  /// camera thread has ended.
  void put_back_gain();
  bool stopped() const { return stop_.load(); }

 private:
  /// Called again and again while frames are waited for; an error ends the wait.
  using Check = std::function<Result<void>(const FrameBroker::Request&)>;

  template <class T>
  Result<T> wait_for(std::future<Result<T>> future);
  Result<double> try_gain(double gain_db);
  Result<void> check_display() const;
  Error no_frame(double waited_s) const;
  Result<void> edit(SensorChange change);
  Result<SpotAverage> spots(int frames, const Check& check);
  std::unique_ptr<FrameBroker::Request> request_pictures(int frames, PictureMean& to) const;
  Result<void> wait_for(const FrameBroker::Request& request, const Check& check) const;

  int job_;
  BenchDeps deps_;
  const std::atomic<bool>& stop_;
  std::atomic<double>& progress_;
  std::optional<double> gain_before_db_;  ///< none: it was not changed
  std::shared_ptr<PendingFiles> files_ = std::make_shared<PendingFiles>();
};

}  // namespace ovws
