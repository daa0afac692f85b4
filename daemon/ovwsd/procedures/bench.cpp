#include "daemon/ovwsd/procedures/bench.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kLook(20);  // how often a wait sees a stop
constexpr double kLeastPatienceS = 10.0;

Error stopped_error() {
  return {Errc::refused, "", "it was told to end"};
}

/// Without a frame for so long, none will come.
double patience_s(const CameraSettings& camera) {
  return std::max(kLeastPatienceS,
                  3.0 * std::max(1.0 / camera.frame_rate_hz, 1e-6 * camera.exposure_us));
}

/// How long what only grows has stood still.
class Silence {
 public:
  explicit Silence(double patience_s) : patience_s_(patience_s) {}

  bool is_too_long(std::size_t count) {
    const std::int64_t now_ns = monotonic_ns();
    if (std::exchange(count_, count) != count) since_ns_ = now_ns;
    return 1e-9 * double(now_ns - since_ns_) > patience_s_;
  }

 private:
  double patience_s_;
  std::size_t count_ = 0;
  std::int64_t since_ns_ = monotonic_ns();
};

}  // namespace

Bench::Bench(int job, const BenchDeps& deps, const std::atomic<bool>& stop,
             std::atomic<double>& progress)
    : job_(job), deps_(deps), stop_(stop), progress_(progress) {}

Error Bench::no_frame(double waited_s) const {
  if (auto there = check_display(); !there) return there.error();
  return {Errc::unavailable, "",
          fmt::format("no settled frame came for {:.0f} s: see system.status for what the camera "
                      "and the SLM do",
                      waited_s)};
}

Result<void> Bench::check_display() const {
  const SlmSnapshot slm = deps_.slm.snapshot();
  if (slm.healthy) return {};
  return fail(Errc::unavailable, "slm",
              fmt::format("the SLM's display was lost in the middle of the job: {}; what the job "
                          "found is dropped, start it again when system.status says that the SLM "
                          "is connected",
                          slm.fault));
}

Result<void> Bench::check_shown(std::int64_t presented_mono_ns) const {
  if (auto there = check_display(); !there) return there;
  if (deps_.slm.snapshot().t_presented_mono_ns == presented_mono_ns) return {};
  return fail(Errc::unavailable, "slm",
              "the SLM's display was lost and came back in the middle of the job: start it again");
}

/// Who is asked may be gone by the time it answers: what it answers into is shared.
template <class T>
Result<T> Bench::wait_for(std::future<Result<T>> future) {
  while (future.wait_for(kLook) != std::future_status::ready) {
    if (stopped()) return fail(stopped_error());
  }
  try {
    return future.get();
  } catch (const std::future_error&) {  // asked of a thread that has ended
    return fail(stopped_error());
  }
}

Result<void> Bench::ask(const std::function<void(Instrument::Changed)>& what) {
  if (stopped()) return fail(stopped_error());
  auto promise = std::make_shared<std::promise<Result<void>>>();
  auto future = promise->get_future();
  what([promise = std::move(promise)](const Result<SensorSnapshot>& shown) {
    promise->set_value(shown ? Result<void>{} : fail(shown.error()));
  });
  auto answer = wait_for(std::move(future));
  if (answer || stopped()) return answer;
  const auto there = check_display();
  if (!there) answer.error().reason = there.error().reason;
  return answer;
}

Result<void> Bench::show(const std::vector<Mode>& aberration) {
  return ask([&](Instrument::Changed done) {
    deps_.instrument.exhibit(job_, {aberration, nullptr}, std::move(done));
  });
}

Result<void> Bench::show(const SensorSet& sensor, const std::vector<Mode>& aberration) {
  return ask([&](Instrument::Changed done) {
    deps_.instrument.exhibit(job_, {aberration, nullptr, sensor}, std::move(done));
  });
}

Result<void> Bench::show(const Painter& paint) {
  return ask([&](Instrument::Changed done) {
    deps_.instrument.exhibit(job_, {{}, paint}, std::move(done));
  });
}

Result<void> Bench::use_registration(const Registration& registration) {
  return ask([&](Instrument::Changed done) {
    deps_.instrument.use_registration(job_, registration, std::move(done));
  });
}

Result<void> Bench::use_calibration(std::uint64_t sensor_epoch, MeasuredCalibration measured) {
  return ask([&](Instrument::Changed done) {
    deps_.instrument.use_calibration(job_, sensor_epoch, std::move(measured), std::move(done));
  });
}

Result<double> Bench::try_gain(double gain_db) {
  if (stopped()) return fail(stopped_error());
  auto promise = std::make_shared<std::promise<Result<double>>>();
  auto future = promise->get_future();
  CameraSet change;
  change.put(&CameraSettings::gain_db, gain_db);
  deps_.camera.change_for_job(
      change, [promise = std::move(promise)](const Result<CameraSnapshot>& set) {
        promise->set_value(set ? Result<double>(set->settings.gain_db) : fail(set.error()));
      });
  return wait_for(std::move(future));
}

Result<double> Bench::set_gain(double gain_db) {
  const CameraSnapshot before = camera();
  if (!gain_before_db_) gain_before_db_ = before.asked.gain_db;
  const std::int64_t begin_ns = monotonic_ns();
  while (true) {
    auto set = try_gain(gain_db);
    if (set || needs_a_person(set.error())) return set;
    if (1e-9 * double(monotonic_ns() - begin_ns) > patience_s(before.settings)) return set;
    std::this_thread::sleep_for(kLook);
  }
}

void Bench::put_back_gain() {
  if (!gain_before_db_) return;
  auto put_back = std::make_shared<std::promise<void>>();
  auto done = put_back->get_future();
  deps_.camera.put_back_gain(*gain_before_db_, [put_back] { put_back->set_value(); });
  put_back.reset();
  done.wait();  // also if the camera thread has ended: the promise is then broken
}

Result<void> Bench::use_lut(MeasuredLut lut) {
  return ask([&](Instrument::Changed done) {
    deps_.instrument.use_lut(job_, std::move(lut), std::move(done));
  });
}

Result<void> Bench::use_flatness(std::uint64_t sensor_epoch, MeasuredFlatness flatness) {
  return ask([&](Instrument::Changed done) {
    deps_.instrument.use_flatness(job_, sensor_epoch, std::move(flatness), std::move(done));
  });
}

Result<void> Bench::watch_on(double least_ms, std::size_t frames) {
  const std::int64_t begin_ns = monotonic_ns();
  const double patient_s = patience_s(camera().settings);
  Silence silence(patient_s);
  const std::size_t enough = deps_.light.count() + frames;
  for (;;) {
    const std::size_t seen = deps_.light.count();
    if (stopped()) return fail(stopped_error());
    if (1e-6 * double(monotonic_ns() - begin_ns) >= least_ms && seen >= enough) return {};
    if (silence.is_too_long(seen)) return fail(no_frame(patient_s));
    std::this_thread::sleep_for(kLook / 10);
  }
}

void Bench::tell(double progress) {
  progress_.store(progress);
  deps_.jobs.tell_progress(job_);
}

Result<ReferenceCollector::Average> Bench::spots(int frames) {
  if (stopped()) return fail(stopped_error());
  const SensorSnapshot now = sensor();
  auto promise = std::make_shared<std::promise<ReferenceCollector::Average>>();
  auto future = promise->get_future();
  deps_.collector.begin(frames, now.sensor_epoch, now.hologram_id, now.subapertures,
                        [promise = std::move(promise)](ReferenceCollector::Average average) {
                          promise->set_value(std::move(average));
                        });
  const double patient_s = patience_s(camera().settings);
  while (future.wait_for(kLook) != std::future_status::ready) {
    const bool silent = deps_.collector.idle_s() > patient_s;
    if (!stopped() && !silent) continue;
    deps_.collector.cancel();
    return fail(stopped() ? stopped_error() : no_frame(patient_s));
  }
  try {
    return future.get();
  } catch (const std::future_error&) {  // another one has begun to collect
    return fail(Errc::internal, "", "the frames were taken from it");
  }
}

Result<std::vector<SeriesFrame>> Bench::series(int frames, std::vector<Vec2> cells) {
  if (stopped()) return fail(stopped_error());
  const SensorSnapshot now = sensor();
  const CameraSettings settings = camera().settings;
  deps_.series.begin({frames, now.sensor_epoch, now.hologram_id, now.tracking.tracker,
                      settings.gain_db, now.subapertures, std::move(cells)});
  const std::shared_ptr<void> ended(nullptr, [this](void*) { (void)deps_.series.end(); });
  Silence silence(patience_s(settings));
  for (int taken = 0; taken < frames; taken = deps_.series.taken()) {
    const bool silent = silence.is_too_long(std::size_t(taken));
    if (stopped() || silent) {
      return fail(stopped() ? stopped_error() : no_frame(patience_s(settings)));
    }
    std::this_thread::sleep_for(kLook / 4);
  }
  return deps_.series.end();
}

Result<Image<float>> Bench::picture(int frames) {
  if (stopped()) return fail(stopped_error());
  const SensorSnapshot now = sensor();
  deps_.pictures.begin(now.sensor_epoch, now.hologram_id, frames);
  const double patient_s = patience_s(camera().settings);
  Silence silence(patient_s);
  while (deps_.pictures.wants()) {
    const bool silent = silence.is_too_long(std::size_t(deps_.pictures.frames()));
    if (stopped() || silent) {
      deps_.pictures.cancel();
      return fail(stopped() ? stopped_error() : no_frame(patient_s));
    }
    std::this_thread::sleep_for(kLook / 4);
  }
  const auto taken = deps_.pictures.end();
  if (!taken) return fail(no_frame(patient_s));
  return taken->mean_dn;
}

}  // namespace ovws
