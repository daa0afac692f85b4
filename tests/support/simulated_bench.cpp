#include "tests/support/simulated_bench.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "core/optics/detector.hpp"
#include "core/port/clock.hpp"
#include "daemon/ovwsd/devices/driver_table.hpp"
#include "daemon/ovwsd/sensor/sensor_changes.hpp"
#include "drivers/twin/bench_model.hpp"
#include "tests/support/own_folder.hpp"

namespace ovws {
namespace test {

using namespace std::chrono_literals;

constexpr auto kPatience = 60s;  // a busy machine is slow

// The optics of this process' bench, for open_display and open_camera.
SimulatedOptics* optics_in_use = nullptr;

struct SimulatedOptics::Model {
  explicit Model(const twin::Config& config)
      : truth(config.truth),
        bench(config),
        grey(config.slm.geometry.width_px, config.slm.geometry.height_px) {}

  twin::Truth truth;
  twin::BenchModel bench;
  Image<std::uint8_t> grey;
  std::optional<Roi> window;
  std::optional<Image<float>> intensity;  ///< cached for the values above; none: outdated
  std::optional<Detector> detector;
  Image<float> photons;
};

SimulatedOptics::SimulatedOptics(const twin::Config& config)
    : model_(std::make_unique<Model>(config)) {
  set_truth(config.truth);
  optics_in_use = this;
}

SimulatedOptics::~SimulatedOptics() {
  optics_in_use = nullptr;
}

void SimulatedOptics::before_show(std::function<void()> call) {
  const std::lock_guard lock(call_mutex_);
  before_show_ = std::move(call);
}

void SimulatedOptics::before_apply(std::function<void()> call) {
  const std::lock_guard lock(mutex_);
  before_apply_ = std::move(call);
}

void SimulatedOptics::apply() {
  std::function<void()> call;
  {
    const std::lock_guard lock(mutex_);
    call = before_apply_;
  }
  if (call) call();
}

void SimulatedOptics::show(const Image<std::uint8_t>& grey) {
  {
    const std::lock_guard lock(call_mutex_);
    if (before_show_) before_show_();
  }
  const std::lock_guard lock(mutex_);
  model_->grey = grey;
  model_->intensity.reset();
}

void SimulatedOptics::set_truth(const twin::Truth& truth) {
  const std::lock_guard lock(mutex_);
  model_->truth = truth;
  model_->bench.set_light(truth);
  model_->window.reset();
  model_->intensity.reset();
  model_->detector.reset();
}

twin::Truth SimulatedOptics::truth() const {
  const std::lock_guard lock(mutex_);
  return model_->truth;
}

std::int64_t SimulatedOptics::expose(const CameraSettings& settings, Image<std::uint16_t>& dn) {
  const std::lock_guard lock(mutex_);
  const std::int64_t begin_ns = monotonic_ns();
  Model& now = *model_;
  if (now.window != settings.roi) {
    now.bench.set_window(settings.roi, now.truth.geometry);
    now.window = settings.roi;
    now.intensity.reset();
    now.detector.reset();
  }
  if (!now.intensity) now.intensity = now.bench.intensity(now.grey);
  if (!now.detector) {
    now.detector.emplace(now.truth.detector, settings.roi.width, settings.roi.height);
    now.photons = Image<float>(settings.roi.width, settings.roi.height);
  }
  const auto scale = float(now.truth.peak_electrons / now.truth.detector.quantum_efficiency *
                           settings.exposure_us / twin::kReferenceExposureUs);
  for (std::size_t i = 0; i < now.photons.pixels.size(); ++i) {
    now.photons.pixels[i] = scale * now.intensity->pixels[i];
  }
  now.detector->expose(now.photons, settings.exposure_us, settings.gain_db, dn);
  return begin_ns;
}

namespace {

class SimulatedDisplay final : public ovws::Display {
 public:
  explicit SimulatedDisplay(const SlmConfig& config)
      : info_{config.display, config.geometry.width_px, config.geometry.height_px, 60.0, "test"} {}
  const DisplayInfo& info() const override { return info_; }
  Result<std::int64_t> present(const Image<std::uint8_t>& grey) override {
    optics_in_use->show(grey);
    return monotonic_ns();
  }
  Result<Image<std::uint32_t>> read_back() override { return fail(Errc::unavailable, "", "no"); }
  Result<void> check() override { return {}; }

 private:
  DisplayInfo info_;
};

/// Simulated Mono8 camera that runs at the configured frame rate.
class SimulatedCamera final : public Camera {
 public:
  SimulatedCamera() { info_ = {"ovws", "simulated", "1", "here"}; }
  const CameraInfo& info() const override { return info_; }
  Result<CameraLimits> limits() override {
    CameraLimits limits;
    limits.gain_db = {0.0, 48.0, 0.0};
    limits.exposure_us = {10.0, 1e6, 0.0};
    limits.frame_rate_hz = {1.0, 1000.0, 0.0};
    limits.roi_width = limits.roi_height = {16, 1024, 1};
    limits.sensor_width = limits.sensor_height = 1024;
    limits.pixel_formats = {PixelFormat::mono8};
    return limits;
  }
  Result<CameraSettings> apply(const CameraSettings& wanted) override {
    optics_in_use->apply();
    const std::lock_guard lock(mutex_);
    settings_ = wanted;
    return wanted;
  }
  Result<void> start() override { return {}; }
  void stop() override {}
  bool alive() const override { return true; }
  int buffer_count() const override { return int(buffers_.size()); }
  GrabStatus grab(GrabbedFrame& out, std::chrono::microseconds timeout) override;
  void release(int slot) OVWS_NONBLOCKING override { buffers_[std::size_t(slot)].lent = false; }

 private:
  struct Buffer {
    std::atomic<bool> lent{false};
    std::vector<std::uint8_t> pixels;
  };

  CameraInfo info_;
  std::mutex mutex_;
  CameraSettings settings_;
  std::array<Buffer, 16> buffers_;
  Image<std::uint16_t> dn_;
  std::uint64_t frame_id_ = 0;
  std::chrono::steady_clock::time_point next_;
};

GrabStatus SimulatedCamera::grab(GrabbedFrame& out, std::chrono::microseconds timeout) {
  using Clock = std::chrono::steady_clock;  // frames come at their rate whatever a test skips
  std::this_thread::sleep_until(std::min(next_, Clock::now() + timeout));
  if (Clock::now() < next_) return GrabStatus::timeout;
  // A change of the settings is done before an exposure begins, or when it has ended.
  const std::lock_guard lock(mutex_);
  const CameraSettings& settings = settings_;
  next_ = std::max(next_, Clock::now()) +
          std::chrono::nanoseconds(std::int64_t(1e9 / settings.frame_rate_hz));
  for (std::size_t slot = 0; slot < buffers_.size(); ++slot) {
    Buffer& buffer = buffers_[slot];
    if (buffer.lent) continue;
    const std::int64_t begin_ns = optics_in_use->expose(settings, dn_);
    buffer.pixels.assign(dn_.pixels.begin(), dn_.pixels.end());
    buffer.lent = true;
    out = GrabbedFrame{};
    out.image = {reinterpret_cast<const std::byte*>(buffer.pixels.data()), dn_.width, dn_.height,
                 dn_.width, PixelFormat::mono8};
    out.frame_id = ++frame_id_;
    out.t_device_ns = begin_ns;
    out.t_arrival_ns = utc_ns();
    // The transfer takes no time, however long a busy machine computes the frame.
    out.t_arrival_mono_ns = begin_ns + std::llround(settings.exposure_us * 1e3);
    out.slot = int(slot);
    return GrabStatus::frame;
  }
  return GrabStatus::timeout;
}

}  // namespace

Config small_daemon_config() {
  Config config;
  config.slm.geometry = {320, 192, 19.0};
  config.slm.settle_ms = 0.0;
  config.optics.focal_length_mm = 30.0;
  config.sensor.pupil_diameter_px = 192.0;
  config.sensor.subapertures_across = 3;
  config.sensor.grooves = {40.0, 4.0};
  config.sensor.spacing = 0.25;
  config.tracking.tracker = TrackerKind::lg;
  config.camera.settings.roi = {0, 0, 256, 256};
  config.camera.settings.frame_rate_hz = 400.0;
  return config;
}

twin::Config small_twin_config() {
  const Config daemon = small_daemon_config();
  twin::Config config;
  config.slm.geometry = daemon.slm.geometry;
  config.optics = daemon.optics;
  config.sensor = daemon.sensor;
  config.light.diameter_px = 300.0;
  config.truth.geometry.centre_px = {127.5, 127.5};
  config.truth.peak_electrons = 4000.0;
  return config;
}

struct SimulatedBench::Turning {
  explicit Turning(Agent& agent)
      : thread([this, &agent] {
          while (!end) agent.do_work();
          agent.on_close();
        }) {}
  ~Turning() {
    end = true;
    thread.join();
  }
  std::atomic<bool> end{false};
  std::thread thread;
};

class SimulatedBench::Publish : public Agent {
 public:
  Publish(Pipeline& pipeline, FrameTaps& frames) : pipeline_(pipeline), frames_(frames) {}
  bool do_work() override {
    if (FrameRecord* record = pipeline_.next(1000)) {
      frames_.serve_numbers(*record);
      pipeline_.release(record);
    }
    if (!requested_ && !frames_.wants_pixels()) return true;
    if (!requested_) pipeline_.request_image();
    requested_ = true;
    if (FrameRecord* record = pipeline_.next_image(100)) {
      frames_.serve_pixels(*record);
      pipeline_.release_image(record);
      requested_ = false;
    }
    return true;
  }

 private:
  Pipeline& pipeline_;
  FrameTaps& frames_;
  bool requested_ = false;
};

class SimulatedBench::Display : public Agent {
 public:
  explicit Display(SlmLoop& slm) : slm_(slm) {}
  bool do_work() override { return slm_.do_work(); }
  void on_close() override { slm_.close(); }

 private:
  SlmLoop& slm_;
};

SimulatedBench::SimulatedBench(Config daemon, const twin::Config& twin)
    : folder_(own_folder("simulated")),
      config_(std::move(daemon)),
      optics_(twin),
      library_(
          [this] {
            config_.state.directory = folder_;
            return config_.state;
          }(),
          events_),
      pipeline_(config_.pipeline, {counters_, shown_, settings_}),
      slm_(config_.slm, {shown_, counters_, events_, [](const SlmSnapshot&) {}}) {
  std::filesystem::remove_all(folder_);
  own_agents_.push_back(std::make_unique<Display>(slm_));
  own_agents_.push_back(std::make_unique<Publish>(pipeline_, frames_));
  camera_ = std::make_unique<CameraActor>(
      config_.camera,
      CameraActorDeps{pipeline_, settings_, counters_, events_, [this](const CameraSnapshot& now) {
                        if (now.connected) keeper_->camera_changed(now.settings, now.info);
                      }});
  start(*own_agents_[0]);
  auto made = SensorKeeper::make(config_, {pipeline_, slm_, events_, library_, leases_,
                                           [](const MeasurementPlan&, SensorView) {}});
  if (!made) throw std::runtime_error(made.error().field + " " + made.error().reason);
  keeper_ = std::move(*made);
  leases_.on_turn([this](Holder holder, std::function<void()> then) {
    keeper_->take_turn(holder, std::move(then));
  });
  for (const auto condition : {&Conditions::started, &Conditions::camera, &Conditions::display}) {
    leases_.set(condition, true);
  }
  procedures_ = std::make_unique<Procedures>(
      BenchDeps{config_, *keeper_, *camera_, frames_, slm_, jobs_, events_});
  start(*own_agents_[1]);
  start(pipeline_.acquisition());
  start(*keeper_);
  start(*camera_);
  start(*procedures_);
  FrameTap first(frames_, FrameTap::Needs::numbers, 1,
                 [](const FrameRecord& record) { return record.settled; });
  EXPECT_TRUE(first.wait_for(kPatience)) << "no frame";
}

/// Ends threads in reverse order of their start, because later ones use earlier ones.
SimulatedBench::~SimulatedBench() {
  procedures_->end_soon();
  while (!threads_.empty()) threads_.pop_back();
  std::filesystem::remove_all(folder_);
}

void SimulatedBench::start(Agent& agent) {
  threads_.push_back(std::make_unique<Turning>(agent));
}

Result<nlohmann::json> SimulatedBench::run(const std::string& kind, Procedure procedure,
                                           Request request) {
  auto lease = leases_.take(request);
  if (!lease) return fail(lease.error());
  std::promise<Result<int>> begun;
  procedures_->start(std::move(*lease), {kind, std::move(procedure)},
                     [this, &begun](Result<int> job) {
                       if (job) job_ = *job;  // now: the procedure may cancel itself at once
                       begun.set_value(std::move(job));
                     });
  const Result<int> job = begun.get_future().get();
  if (!job) return fail(job.error());
  for (const auto end = std::chrono::steady_clock::now() + kPatience;
       std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(2ms)) {
    const auto report = jobs_.get(*job);
    if (report->state == JobState::running) continue;
    if (report->error) return fail(*report->error);
    if (report->state == JobState::cancelled) return fail(Errc::refused, "", "it was cancelled");
    return report->result;
  }
  return fail(Errc::unavailable, "", "the job does not end");
}

Result<SensorView> SimulatedBench::edit(SensorChange change) {
  const auto lease = leases_.take(Request::set_sensor);
  if (!lease) return fail(lease.error());
  std::promise<Result<SensorView>> done;
  keeper_->edit(std::move(change),
                [&done](Result<SensorView> now) { done.set_value(std::move(now)); });
  return done.get_future().get();
}

std::vector<double> SimulatedBench::mean_waves(int frames) {
  const std::uint64_t hologram_id = sensor()->hologram_id;
  std::vector<double> sums(sensor()->modes_j.size());
  FrameTap tap(frames_, FrameTap::Needs::numbers, frames, [&](const FrameRecord& record) {
    const bool good = record.settled && record.valid && record.hologram_id == hologram_id &&
                      std::size_t(record.mode_count) == sums.size();
    for (std::size_t k = 0; good && k < sums.size(); ++k) {
      sums[k] += double(record.coefficients[k]) / frames;
    }
    return good;
  });
  return tap.wait_for(kPatience) ? sums : std::vector<double>{};
}

}  // namespace test

Result<std::unique_ptr<Display>> open_display(const SlmConfig& config) {
  return std::make_unique<test::SimulatedDisplay>(config);
}
Result<std::unique_ptr<Camera>> open_camera(const CameraConfig& /*config*/) {
  return std::make_unique<test::SimulatedCamera>();
}

}  // namespace ovws
