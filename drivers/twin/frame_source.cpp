#include "drivers/twin/frame_source.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

#include "drivers/twin/pixel_packing.hpp"

namespace ovws::twin {
namespace {

constexpr std::size_t kAhead = 1;  // frames generated in advance: a new scene discards them
constexpr std::size_t kFreshHistory = 16;
constexpr std::size_t kPool = 32;

std::size_t history_of(Noise noise) {
  if (noise == Noise::none) return 1;
  return noise == Noise::pool ? kPool : kFreshHistory;
}

int converter_bits(const Truth& truth, PixelFormat format) {
  return truth.bits > 0 ? truth.bits : significant_bits(format);
}

DetectorConfig detector_config(const Truth& truth, PixelFormat format) {
  DetectorConfig config = truth.detector;
  config.bits = converter_bits(truth, format);
  // Black level is configured for 8 bits; scaled so that any converter has equal electrons.
  config.black_level_dn *= std::exp2(config.bits - 8);
  if (truth.noise == Noise::none) {
    config.prnu = 0.0;
    config.shot_noise = false;
    config.read_noise_e = 0.0;
  }
  return config;
}

auto fields(const DetectorConfig& c) {
  return std::tie(c.quantum_efficiency, c.prnu, c.shot_noise, c.dark_current_e_per_s,
                  c.read_noise_e, c.full_well_e, c.black_level_dn, c.bits, c.seed);
}

}  // namespace

bool FrameSource::may_repeat() const {
  return past_.size() >= history_of(request_->scene->truth.noise);
}

bool FrameSource::wants_more() const {
  if (!request_ || ready_.size() >= kAhead) return false;
  // With turbulence or a moving mirror each frame shows another scene, so one frame is enough.
  if (takes_ < 2) return ready_.empty() && past_.empty();
  return request_->scene->truth.noise == Noise::fresh ||
         ready_.size() + past_.size() < history_of(request_->scene->truth.noise);
}

FrameSource::Frame FrameSource::make(const FrameRequest& request) {
  const Truth& truth = request.scene->truth;
  const DetectorConfig config = detector_config(truth, request.format);
  const Image<float>& intensity = *request.scene->intensity;
  const bool same = detector_ && fields(config) == fields(detector_config_) &&
                    intensity.width == photons_.width && intensity.height == photons_.height;
  if (!same) {
    detector_.emplace(config, intensity.width, intensity.height);
    detector_config_ = config;
    photons_ = Image<float>(intensity.width, intensity.height);
  }
  const float scale = float(truth.peak_electrons / config.quantum_efficiency * request.exposure_us /
                            kReferenceExposureUs);
  using Values = Eigen::Map<const Eigen::ArrayXf>;
  const auto count = Eigen::Index(intensity.pixels.size());
  Eigen::Map<Eigen::ArrayXf>(photons_.pixels.data(), count) =
      scale * Values(intensity.pixels.data(), count);
  filter_colours(photons_, request.format, wavelength_nm_);
  detector_->expose(photons_, request.exposure_us, request.gain_db, dn_);
  return std::make_shared<std::vector<std::byte>>(
      packed(dn_, config.bits, request.format, truth.left_justified));
}

void FrameSource::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return wants_more(); })) {
    const FrameRequest request = *request_;
    lock.unlock();
    Frame frame = make(request);
    lock.lock();
    if (request == *request_) ready_.push_back(std::move(frame));
    changed_.notify_all();
  }
}

bool FrameSource::take(const FrameRequest& request, Bench::Deadline deadline,
                       const std::stop_token& stop, std::span<std::byte> out) {
  std::unique_lock lock(mutex_);
  if (request_ != request) {
    request_ = request;
    takes_ = 0;
    ready_.clear();
    past_.clear();
  }
  ++takes_;
  changed_.notify_all();
  if (!changed_.wait_until(lock, stop, deadline,
                           [this] { return !ready_.empty() || may_repeat(); })) {
    return false;
  }
  Frame frame;
  if (!ready_.empty()) {
    frame = std::move(ready_.front());
    ready_.pop_front();
    ++counts_.fresh;
  } else {
    frame = std::move(past_.front());
    past_.pop_front();
    if (request_->scene->truth.noise == Noise::fresh) ++counts_.reused;
  }
  past_.push_back(frame);
  if (past_.size() > history_of(request_->scene->truth.noise)) past_.pop_front();
  lock.unlock();
  if (frame->size() != out.size()) return false;
  std::memcpy(out.data(), frame->data(), out.size());
  return true;
}

FrameCounts FrameSource::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

}  // namespace ovws::twin
