#include "daemon/ovwsd/procedures/bench.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "core/port/clock.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kPollInterval(20);  // interval of checks for a stop of the job
constexpr double kMinPatienceS = 10.0;
constexpr std::chrono::milliseconds kFilePatience(2000);

Error stopped_error() {
  return {Errc::refused, "", "the job was stopped"};
}

/// Longest wait for the next frame, s: three frame periods or exposures, at least 10 s.
double patience_s(const CameraSettings& camera) {
  return std::max(kMinPatienceS,
                  3.0 * std::max(1.0 / camera.frame_rate_hz, 1e-6 * camera.exposure_us));
}

MeasuredUnder measured_under(const SensorSnapshot& sensor,
                             std::optional<CameraSettings> camera = {}) {
  return {sensor.sensor_epoch, sensor.hologram_id, camera};
}

}  // namespace

Error Bench::no_frame(double waited_s) const {
  if (auto there = check_display(); !there) return there.error();
  return {Errc::unavailable, "",
          fmt::format("no settled frame arrived for {:.0f} s: check the camera and the SLM in "
                      "system.status",
                      waited_s)};
}

Result<void> Bench::check_display() const {
  const SlmSnapshot slm = deps_.slm.snapshot();
  if (slm.healthy) return {};
  return fail(Errc::unavailable, "slm",
              fmt::format("the SLM's display was lost in the middle of the job: {}; the job's "
                          "results are discarded, start it again when system.status reports the "
                          "SLM as connected",
                          slm.fault));
}

Result<void> Bench::check_shown(std::int64_t presented_mono_ns) const {
  if (auto there = check_display(); !there) return there;
  if (deps_.slm.snapshot().t_presented_mono_ns == presented_mono_ns) return {};
  return fail(Errc::unavailable, "slm",
              "the SLM's display was lost and came back during the job: start the job again");
}

/// Waits for the result of another thread, or for a stop of the job. Callers share the promise with
/// that thread, because the result may come after this call has returned.
template <class T>
Result<T> Bench::wait_for(std::future<Result<T>> future) {
  while (future.wait_for(kPollInterval) != std::future_status::ready) {
    if (stopped()) return fail(stopped_error());
  }
  try {
    return future.get();
  } catch (const std::future_error&) {  // the other thread ended without an answer
    return fail(stopped_error());
  }
}

Result<void> Bench::edit(SensorChange change) {
  if (stopped()) return fail(stopped_error());
  // The promise is set once, in the prepare thread, when the change is active or has failed.
  auto promise = std::make_shared<std::optional<std::promise<Result<void>>>>(std::in_place);
  auto future = (*promise)->get_future();
  const auto answer = [promise](Result<void> result) {
    if (!*promise) return;
    (*promise)->set_value(std::move(result));
    promise->reset();
  };
  promise.reset();
  deps_.keeper.edit(
      std::move(change),
      [answer, end = end_](const Result<SensorView>& done) {
        if (!done) answer(fail(done.error()));
      },
      [answer] { answer({}); });
  auto result = wait_for(std::move(future));
  if (result || stopped()) return result;
  const auto there = check_display();
  if (!there) result.error().reason = there.error().reason;
  return result;
}

Result<void> Bench::show(const std::vector<Mode>& aberration) {
  return edit(show_request({aberration, nullptr}));
}

Result<void> Bench::show(const SensorSet& sensor, const std::vector<Mode>& aberration) {
  return edit(show_request({aberration, nullptr, sensor}));
}

Result<void> Bench::show(const Painter& paint) {
  return edit(show_request({{}, paint}));
}

Result<std::int64_t> Bench::wait_settled() const {
  while (!stopped()) {
    if (auto there = check_display(); !there) return fail(there.error());
    const SlmSnapshot slm = deps_.slm.snapshot();
    const std::chrono::nanoseconds left(slm.t_settled_mono_ns - monotonic_ns());
    if (slm.hologram_id == sensor()->hologram_id && left.count() <= 0) return slm.t_settled_mono_ns;
    std::this_thread::sleep_for(
        std::clamp<std::chrono::nanoseconds>(left, std::chrono::microseconds(100), kPollInterval));
  }
  return fail(stopped_error());
}

Result<void> Bench::use(SensorChange change, Step step) {
  const auto used = edit([&jobs = deps_.jobs, job = job_, step,
                          change = std::move(change)](SensorEdit& edit) -> Result<void> {
    const bool runs = step == Step::last ? jobs.use_result(job) : jobs.runs(job);
    if (!runs) return fail(Errc::refused, "", "it was cancelled");
    return change(edit);
  });
  if (!used) return used;
  constexpr auto kWait = kPollInterval / 10;
  for (auto left = kFilePatience; left.count() > 0 && !stopped(); left -= kWait) {
    if (end_.use_count() == 1) break;  // no file is being written
    std::this_thread::sleep_for(kWait);
  }
  return used;
}

void Bench::publish_info(std::string kind, std::string text, nlohmann::json data) {
  deps_.events.emit(std::move(kind), Severity::info, std::move(text), std::move(data));
}

void Bench::warn(std::string kind, std::string text, nlohmann::json data) {
  deps_.events.emit(std::move(kind), Severity::warning, std::move(text), std::move(data));
}

Result<CameraSnapshot> Bench::try_camera(const CameraSet& change) {
  if (stopped()) return fail(stopped_error());
  auto promise = std::make_shared<std::promise<Result<CameraSnapshot>>>();
  auto future = promise->get_future();
  deps_.camera.change(change, [promise = std::move(promise)](Result<CameraSnapshot> set) {
    promise->set_value(std::move(set));
  });
  return wait_for(std::move(future));
}

Result<CameraSnapshot> Bench::set_camera(const CameraSet& change) {
  const CameraSnapshot before = camera();
  camera_before_ = before.undo_of(change, std::move(camera_before_));
  const std::int64_t begin_ns = monotonic_ns();
  while (true) {
    auto set = try_camera(change);
    if (set || needs_intervention(set.error())) return set;
    if (1e-9 * double(monotonic_ns() - begin_ns) > patience_s(before.settings)) return set;
    std::this_thread::sleep_for(kPollInterval);
  }
}

Result<void> Bench::keep_camera() {
  if (!deps_.jobs.use_result(job_)) return fail(stopped_error());
  camera_before_ = {};
  return {};
}

void Bench::restore_camera() {
  if (camera_before_.given().empty()) return;
  auto restored = std::make_shared<std::promise<void>>();
  auto done = restored->get_future();
  deps_.camera.restore(camera_before_, [restored] { restored->set_value(); });
  restored.reset();
  done.wait();  // returns also if the camera thread has ended, which breaks the promise
}

Result<void> Bench::wait_watching(const FrameTap& watch, double min_ms, int frames) {
  const std::int64_t begin_ns = monotonic_ns();
  const double patient_s = patience_s(camera().settings);
  const std::int64_t enough = watch.used() + frames;
  while (1e-6 * double(monotonic_ns() - begin_ns) < min_ms || watch.used() < enough) {
    if (stopped()) return fail(stopped_error());
    if (watch.idle_s() > patient_s) return fail(no_frame(patient_s));
    std::this_thread::sleep_for(kPollInterval / 10);
  }
  return {};
}

void Bench::report_progress(double progress) {
  live_.progress.store(part_.first + part_.second * progress);
  deps_.jobs.report_progress(job_);
}

Result<void> Bench::wait_for(FrameTap& tap, const Check& check) const {
  const double patient_s = patience_s(camera().settings);
  while (!stopped() && !tap.wait_for(kPollInterval)) {
    if (auto good = check ? check(tap) : Result<void>(); !good) return good;
    if (tap.idle_s() > patient_s) return fail(no_frame(patient_s));
  }
  if (stopped()) return fail(stopped_error());
  return {};
}

Result<SpotAverage> Bench::spots(int frames, std::vector<SpotAverage>* beams) {
  const SensorView now = sensor();
  return spots(*now, measured_under(*now), frames, nullptr, beams);
}

Result<SpotAverage> Bench::spots(const SensorSnapshot& now, const MeasuredUnder& under, int frames,
                                 const Check& check, std::vector<SpotAverage>* beams) {
  SpotAverager averager(frames, now.subapertures);
  std::vector<SpotAverager> further(now.beams.size(), averager);
  const auto add_beams = [&](const FrameRecord& record) {
    for (std::size_t k = 0; k < further.size(); ++k) (void)further[k].add(*record.beams()[k]);
    return true;
  };
  FrameTap tap(deps_.frames, FrameTap::Needs::numbers, frames, [&](const FrameRecord& record) {
    return under.settled(record) && averager.add(record) && add_beams(record);
  });
  if (auto taken = wait_for(tap, check); !taken) return fail(taken.error());
  for (std::size_t k = 0; beams != nullptr && k < further.size(); ++k) {
    beams->push_back(further[k].average());
  }
  return averager.average();
}

Result<TakenReference> Bench::reference(int frames, const std::string& only) {
  const CameraSettings settings = camera().settings;
  const SensorView now = sensor();
  const MeasuredUnder under = measured_under(*now, settings);
  const auto same_camera = [&]() -> Result<void> {
    if (camera().settings == settings) return {};
    return fail(Errc::refused, "camera",
                "the camera's settings changed during the job; start it again");
  };
  ImageMean picture;
  FrameTap pictures = tap_images(under, ImageMean::kMaxFrames, picture);
  const auto check = [&](const FrameTap& spots) {
    report_progress(double(spots.used()) / frames);
    return same_camera();
  };
  std::vector<SpotAverage> beams;
  auto average = spots(*now, under, frames, check, &beams);
  pictures.close();
  if (!average) return fail(average.error());
  if (auto same = same_camera(); !same) return fail(same.error());
  return TakenReference{only, std::move(*average), std::move(beams), picture.mean(), settings};
}

/// Averages images into `to`, which must outlive the tap.
FrameTap Bench::tap_images(const MeasuredUnder& under, int frames, ImageMean& to) const {
  return {deps_.frames, FrameTap::Needs::pixels, frames, [&to, under](const FrameRecord& record) {
            return under.still(record) && to.add(record);
          }};
}

Result<Image<float>> Bench::picture(int frames) {
  ImageMean picture;
  FrameTap tap = tap_images(measured_under(*sensor(), camera().settings), frames, picture);
  if (auto all = wait_for(tap); !all) return fail(all.error());
  return picture.mean()->mean_dn;
}

}  // namespace ovws
