/// loop.identify: watches the disturbance, and identifies it for the control laws.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/frames/frame_copy.hpp"
#include "daemon/ovwsd/procedures/measurements.hpp"

namespace ovws {
namespace {

constexpr double kTurnMs = 20.0;
constexpr std::chrono::microseconds kNow(0);
constexpr std::size_t kRing = 256;  // frames that may wait for a turn
constexpr std::size_t kLeastFrames = 100;
constexpr double kMostSamples = 30'000.0;  // bounds the memory

/// Disturbances: residuals plus shown corrections, of the modes that the first frame has. Frames of
/// one hologram within `sample_s` are averaged to one sample, so that the memory does not grow with
/// the frame rate, and that a closed loop's bursts of frames count once.
class Series {
 public:
  explicit Series(double sample_s) : sample_ns_(std::llround(1e9 * sample_s)) {}

  void add(const FrameCopy& frame) {
    if (modes_j_.empty()) begin(frame);
    const bool has_all = std::size_t(frame.measured_count) >= modes_j_.size() &&
                         std::equal(modes_j_.begin(), modes_j_.end(), frame.modes_j.begin());
    if (!has_all || frame.t_middle_ns() <= last_ns_) return;
    const bool over = frame.t_middle_ns() - sample_began_ns_ >= 3 * sample_ns_ / 4;  // with jitter
    if (frame.hologram_id != hologram_id_ || over) {
      end_sample();
      hologram_id_ = frame.hologram_id;
      sample_began_ns_ = frame.t_middle_ns();
    }
    last_ns_ = frame.t_middle_ns();
    ++frames_;
    sample_.frames += 1.0;
    sample_.time_s += 1e-9 * double(frame.t_middle_ns() - t_first_ns_);
    for (std::size_t k = 0; k < modes_j_.size(); ++k) {
      double shown = 0.0;
      for (const Mode& mode : frame.shown()) shown += mode.j == modes_j_[k] ? mode.waves : 0.0;
      sample_.waves[k] += double(frame.coefficients[k]) + shown;
      const double sigma = double(frame.sigma_waves[k]);
      if (!std::isfinite(sigma)) continue;
      squares_[k] += sigma * sigma;
      known_[k] += 1.0;
    }
  }

  std::size_t frames() const { return frames_; }

  DisturbanceSeries end() {
    end_sample();
    DisturbanceSeries all{std::move(modes_j_), {std::move(times_s_), std::move(waves_)}, {}};
    const auto frames = double(std::max<std::size_t>(frames_, 1));
    for (std::size_t k = 0; k < squares_.size(); ++k) {
      all.sigma_waves.push_back(std::sqrt(squares_[k] / std::max(known_[k], 1.0)));
    }
    all.frames_per_sample = frames / double(std::max<std::size_t>(all.waves.times_s.size(), 1));
    return all;
  }

 private:
  struct Sample {
    double frames = 0.0, time_s = 0.0;
    std::vector<double> waves;
  };

  void begin(const FrameCopy& frame) {
    t_first_ns_ = frame.t_middle_ns();
    modes_j_.assign(frame.modes_j.begin(), frame.modes_j.begin() + frame.measured_count);
    waves_.resize(modes_j_.size());
    squares_.resize(modes_j_.size());
    known_.resize(modes_j_.size());
    sample_.waves.resize(modes_j_.size());
  }

  void end_sample() {
    if (sample_.frames == 0.0) return;
    times_s_.push_back(sample_.time_s / sample_.frames);
    for (std::size_t k = 0; k < modes_j_.size(); ++k) {
      waves_[k].push_back(std::exchange(sample_.waves[k], 0.0) / sample_.frames);
    }
    sample_.frames = sample_.time_s = 0.0;
  }

  std::int64_t sample_ns_;
  std::int64_t t_first_ns_ = 0, last_ns_ = 0, sample_began_ns_ = 0;
  std::uint64_t hologram_id_ = 0;
  std::size_t frames_ = 0;
  Sample sample_;  ///< sums over its frames
  std::vector<int> modes_j_;
  std::vector<double> times_s_;
  std::vector<double> squares_, known_;  ///< of each mode's standard errors: sum, number
  std::vector<std::vector<double>> waves_;
};

/// Whether coefficients mean the same with both.
bool counts_alike(const SensorSnapshot& a, const SensorSnapshot& b) {
  const auto taken_ns = [](const auto& measured) { return measured ? measured->t_taken_ns : 0; };
  return a.sensor_epoch == b.sensor_epoch && a.aberration == b.aberration &&
         taken_ns(a.reference) == taken_ns(b.reference) &&
         taken_ns(a.calibration) == taken_ns(b.calibration);
}

}  // namespace

Result<DisturbanceSeries> watch_disturbance(Bench& bench, double seconds, double sample_s) {
  FrameFeed frames(bench.frames(), kRing, [](const FrameRecord& record) {
    return record.valid && is_of_own_hologram(record);
  });
  const SensorView sensor = bench.sensor();
  Series series(std::max(sample_s, seconds / kMostSamples));
  const std::int64_t began_ns = monotonic_ns();
  FrameCopy frame;
  for (double waited_s = 0.0; waited_s < seconds;
       waited_s = 1e-9 * double(monotonic_ns() - began_ns)) {
    bench.report_progress(kWatchingShare * waited_s / seconds);
    if (auto waited = bench.wait_watching(frames.tap(), kTurnMs, 0); !waited) {
      return fail(waited.error());
    }
    if (!counts_alike(*bench.sensor(), *sensor)) {
      return fail(Errc::refused, "",
                  "sensor, aberration, reference or calibration changed while the frames were "
                  "watched: run loop.identify again");
    }
    while (frames.next(frame, kNow)) series.add(frame);
  }
  if (series.frames() >= kLeastFrames) return series.end();
  return fail(Errc::refused, "",
              fmt::format("only {} usable frames came in {:g} s, and {} are needed: check in the "
                          "status why frames are not valid, or watch for longer",
                          series.frames(), seconds, kLeastFrames));
}

LoopTiming estimated_timing(const Config& config, const CameraSettings& camera, double refresh_hz) {
  const double frame_s = camera.frame_rate_hz > 0.0 ? 1.0 / camera.frame_rate_hz : 0.0;
  const double settle_s = 1e-3 * config.slm.settle_ms, exposure_s = 1e-6 * camera.exposure_us;
  const double needed_s = settle_s + 1e-3 * config.camera.transfer_ms + exposure_s + 0.5 * frame_s;
  const double step_s = refresh_hz > 0.0 ? std::ceil(needed_s * refresh_hz) / refresh_hz : needed_s;
  const double middle_s = settle_s + 0.5 * (frame_s + exposure_s);  // of the frame
  return {step_s, step_s + 0.5 * (step_s + settle_s) - middle_s};
}

}  // namespace ovws
