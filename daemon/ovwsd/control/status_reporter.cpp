#include "daemon/ovwsd/control/status_reporter.hpp"

#include <spdlog/fmt/fmt.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <thread>

#include "core/port/clock.hpp"
#include "daemon/shared/service_notify.hpp"
#include "proto/names.hpp"

namespace ovws {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000'000;
constexpr double kStopTimeoutS = 1.5;
constexpr auto kTurn = std::chrono::milliseconds(20);

std::optional<std::string> if_any(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional(text);
}

StatusMessage::CameraPart camera_part(const CameraSnapshot& camera, const Pipeline& pipeline) {
  StatusMessage::CameraPart part;
  part.connected = camera.connected;
  part.streaming = camera.connected && pipeline.last_frame_mono_ns() != 0;
  part.info = camera.info;
  part.settings = camera.settings;
  part.fault = if_any(camera.fault);
  return part;
}

StatusMessage::SlmPart slm_part(const SlmSnapshot& slm) {
  StatusMessage::SlmPart part;
  part.connected = slm.healthy;
  part.info = slm.info;
  part.pattern = wire_name(slm.kind);
  part.hologram_id = slm.hologram_id;
  part.settled = slm.healthy && monotonic_ns() >= slm.t_settled_mono_ns;
  part.fault = if_any(slm.fault);
  return part;
}

std::string reference_state(const SensorSnapshot& sensor, const CameraSnapshot& camera) {
  if (!sensor.reference) return "none";
  return stale_fields(*sensor.reference, camera.settings).empty() ? "in_force" : "stale";
}

StatusMessage::SensorPart sensor_part(const SensorSnapshot& sensor, const CameraSnapshot& camera) {
  StatusMessage::SensorPart part;
  part.settings = {sensor.sensor, sensor.tracking};
  part.settings.sensor.lenslets = {};  // too many for each message; sensor.get has them
  part.mode_operator = sensor.mode_operator;
  part.subapertures = sensor.subapertures;
  part.modes = int(sensor.modes_j.size());
  part.measurable = sensor.plan_id != 0;
  part.referenced = sensor.reference != nullptr;
  part.reference = reference_state(sensor, camera);
  if (sensor.reference) {
    part.reference_introduced_rms_waves = rms_waves(sensor.reference->introduced);
  }
  part.layout_fault = sensor.layout_fault;
  for (const BeamShown& beam : sensor.beams) {
    part.beams.push_back({beam.name, beam.offset_px, beam.referenced, std::nullopt});
  }
  return part;
}

/// One line for `systemctl status`.
std::string status_line(const StatusMessage& status) {
  std::string line = fmt::format("{}: {:.1f} frames/s, hologram {}", status.state,
                                 status.rates.published_hz, status.slm.hologram_id);
  if (status.camera.fault) line += "; camera: " + *status.camera.fault;
  if (status.slm.fault) line += "; slm: " + *status.slm.fault;
  return line;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> versions() {
  return {{"ovws", OVWS_VERSION},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}};
}

StatusReporter::StatusReporter(StatusDeps deps)
    : deps_(std::move(deps)), started_ns_(monotonic_ns()) {}

bool StatusReporter::do_work() {
  std::this_thread::sleep_for(kTurn);
  watch_threads();
  feed_watchdog();
  deps_.reloader.poll();
  deps_.clients.turn();
  const bool asked = deps_.queue.take_status_request();
  const bool due = monotonic_ns() >= next_ns_;
  if (!asked && !due) return false;
  if (due) {
    next_ns_ = monotonic_ns() + kPeriodNs;
    measure();
  }
  StatusMessage status = current();
  service::notify_status(status_line(status));
  deps_.queue.put(std::move(status));
  return true;
}

StatusMessage StatusReporter::current() const {
  StatusMessage status;
  status.t_ns = utc_ns();
  status.uptime_s = 1e-9 * double(monotonic_ns() - started_ns_);
  const Leases::Report leases = deps_.leases.report();
  status.state = state_name(leases.state);
  status.fault = leases.fault;
  status.loop_closed = deps_.loop.is_closed();
  status.loop_paused = deps_.loop.is_paused();
  const CameraSnapshot camera = deps_.camera.snapshot();
  status.camera = camera_part(camera, deps_.pipeline);
  status.camera.brightest = deps_.images.brightness().newest(monotonic_ns());
  status.slm = slm_part(deps_.slm.snapshot());
  status.store = deps_.library.report();
  for (const HungThread& one : deps_.threads.hung_threads()) {
    if (one.row->role == ThreadRole::display) {
      status.slm.fault =
          fmt::format("the display has not answered for {:.0f} s: check the X server", one.turn_s);
    }
    if (one.row->role == ThreadRole::disk) {
      status.store.reason = fmt::format(
          "the disk has not answered for {:.0f} s: check it; items waiting to be written: {}",
          one.turn_s, deps_.library.queued());
    }
  }
  status.sensor = sensor_part(*deps_.keeper.snapshot(), camera);
  status.sensor.invalid = deps_.search.why_invalid();
  for (std::size_t k = 0; k < status.sensor.beams.size(); ++k) {
    const auto why = deps_.search.why_invalid(k + 1);
    if (why) status.sensor.beams[k].reason = in_words(*why);
  }
  status.refine = deps_.refiner.report();
  status.record = deps_.recorder.report();
  status.failed_job = deps_.jobs.last_failed();
  const Measured measured = measured_.get();
  status.rates = measured.rates;
  if (leases.state != DaemonState::job_running) {
    status.rates.expected_hz = camera.expected_hz(measured.t_begin_ns);
  }
  status.latency = measured.latency;
  for (std::size_t i = 0; i < std::size_t(Counter::count_); ++i) {
    status.counters.emplace_back(counter_name(Counter(i)), deps_.counters.get(Counter(i)));
  }
  status.versions = versions();
  return status;
}

/// Measures rates and latencies since the last call, about one second ago.
void StatusReporter::measure() {
  const Marks now{monotonic_ns(), deps_.counters.get(Counter::frames_grabbed),
                  deps_.counters.get(Counter::frames_published), deps_.images.sent()};
  const auto rate = [&](std::uint64_t after, std::uint64_t before) {
    return 1e9 * double(after - before) / double(std::max<std::int64_t>(now.t_ns - marks_.t_ns, 1));
  };
  Measured measured;
  measured.t_begin_ns = marks_.t_ns;
  if (marks_.t_ns != 0) {
    measured.rates = {rate(now.grabbed, marks_.grabbed), rate(now.published, marks_.published),
                      rate(now.images, marks_.images), std::nullopt};
  }
  measured.latency = {{"arrived", deps_.pipeline.latencies().arrived.take()},
                      {"tracked", deps_.pipeline.latencies().tracked.take()},
                      {"reconstructed", deps_.pipeline.latencies().reconstructed.take()},
                      {"published", deps_.published_latency.take()}};
  marks_ = now;
  measured_.set(std::move(measured));
}

/// Emits an event for each thread that has stopped running or has recovered. Ends the process if
/// the display blocks a requested stop.
void StatusReporter::watch_threads() {
  if (deps_.threads.stop_overdue(kStopTimeoutS)) deps_.end_without_display();
  std::set<const ThreadRow*> hung;
  for (const HungThread& one : deps_.threads.hung_threads()) {
    hung.insert(one.row);
    if (hung_.contains(one.row)) continue;
    deps_.events.emit("thread", Severity::error,
                      fmt::format("thread {} has not run for {:.0f} s; it may be waiting for: {}",
                                  one.row->name, one.turn_s, one.row->may_wait_for));
  }
  for (const ThreadRow* row : hung_) {
    if (hung.contains(row)) continue;
    deps_.events.emit("thread", Severity::info, fmt::format("thread {} has recovered", row->name));
  }
  hung_ = std::move(hung);
}

/// Feeds the systemd watchdog, except while a thread is hung that only a restart can recover.
void StatusReporter::feed_watchdog() {
  const auto ours = [](const ThreadRow* row) { return row->on_hang == OnHang::restart; };
  if (std::any_of(hung_.begin(), hung_.end(), ours)) return;
  const std::uint64_t interval_us = service::watchdog_interval_us();
  if (interval_us == 0 || monotonic_ns() < next_feed_ns_) return;
  service::notify_watchdog();
  next_feed_ns_ = monotonic_ns() + std::int64_t(interval_us) * 1000 / 3;
}

}  // namespace ovws
