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
constexpr std::size_t kMaxBytes = std::size_t(512) << 20;  // of all pools

std::size_t wanted_history(Noise noise) {
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

FrameSource::Pool* FrameSource::find(const FrameRequest& request) {
  const auto found = std::find_if(pools_.begin(), pools_.end(),
                                  [&](const Pool& pool) { return pool.request == request; });
  return found == pools_.end() ? nullptr : &*found;
}

FrameSource::Pool& FrameSource::find_or_add(const FrameRequest& request) {
  if (Pool* const pool = find(request)) return *pool;
  if (!pools_.empty()) {
    FrameRequest same = pools_.front().request;
    same.exposed = request.exposed;
    if (same != request) pools_.clear();
  }
  return pools_.emplace_back(Pool{request, 0, {}, {}});
}

std::size_t FrameSource::history_of(const Pool& pool) const {
  const FrameRequest& request = pool.request;
  const Image<float>& size = *request.scene->patterns[std::size_t(request.exposed.first)].intensity;
  const std::size_t bytes = frame_bytes(request.format, size.width, size.height) * pools_.size();
  return std::clamp(kMaxBytes / bytes, std::size_t(1), wanted_history(request.scene->truth.noise));
}

bool FrameSource::wants_more(const Pool& pool) const {
  if (pool.ready.size() >= kAhead) return false;
  // With turbulence or a moving mirror each frame shows another scene, so one frame is enough.
  if (pool.takes < 2) return pool.ready.empty() && pool.past.empty();
  return pool.request.scene->truth.noise == Noise::fresh ||
         pool.ready.size() + pool.past.size() < history_of(pool);
}

/// The pool for which a frame is generated next; the one that the camera waits for comes first.
const FrameSource::Pool* FrameSource::wanting() const {
  if (newest_ != nullptr && wants_more(*newest_)) return newest_;
  const auto found = std::find_if(pools_.begin(), pools_.end(),
                                  [this](const Pool& pool) { return wants_more(pool); });
  return found == pools_.end() ? nullptr : &*found;
}

FrameSource::Frame FrameSource::make(const FrameRequest& request) {
  const Truth& truth = request.scene->truth;
  const DetectorConfig config = detector_config(truth, request.format);
  const auto light = [&request](int n) -> const Image<float>& {
    const auto& patterns = request.scene->patterns;
    return *patterns[std::size_t(request.exposed.first + n) % patterns.size()].intensity;
  };
  const Image<float>& intensity = light(0);
  const bool same = detector_ && fields(config) == fields(detector_config_) &&
                    intensity.width == photons_.width && intensity.height == photons_.height;
  if (!same) {
    detector_.emplace(config, intensity.width, intensity.height);
    detector_config_ = config;
    photons_ = Image<float>(intensity.width, intensity.height);
  }
  const float scale = float(truth.peak_electrons / config.quantum_efficiency * request.exposure_us /
                            kReferenceExposureUs / request.exposed.count);
  using Values = Eigen::Map<const Eigen::ArrayXf>;
  const auto count = Eigen::Index(intensity.pixels.size());
  Eigen::Map<Eigen::ArrayXf> photons(photons_.pixels.data(), count);
  photons = scale * Values(intensity.pixels.data(), count);
  for (int n = 1; n < request.exposed.count; ++n) {
    photons += scale * Values(light(n).pixels.data(), count);
  }
  filter_colours(photons_, request.format, wavelength_nm_);
  detector_->expose(photons_, request.exposure_us, request.gain_db, dn_);
  return std::make_shared<std::vector<std::byte>>(
      packed(dn_, config.bits, request.format, truth.left_justified));
}

void FrameSource::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return wanting() != nullptr; })) {
    const FrameRequest request = wanting()->request;
    lock.unlock();
    Frame frame = make(request);
    lock.lock();
    if (Pool* const pool = find(request)) pool->ready.push_back(std::move(frame));
    changed_.notify_all();
  }
}

bool FrameSource::take(const FrameRequest& request, Bench::Deadline deadline,
                       const std::stop_token& stop, std::span<std::byte> out) {
  std::unique_lock lock(mutex_);
  Pool& pool = find_or_add(request);
  newest_ = &pool;
  ++pool.takes;
  if (wanting() != nullptr) changed_.notify_all();
  const auto may_repeat = [&] { return pool.past.size() >= history_of(pool); };
  if (!changed_.wait_until(lock, stop, deadline,
                           [&] { return !pool.ready.empty() || may_repeat(); })) {
    return false;
  }
  Frame frame;
  if (!pool.ready.empty()) {
    frame = std::move(pool.ready.front());
    pool.ready.pop_front();
    ++counts_.fresh;
  } else {
    frame = std::move(pool.past.front());
    pool.past.pop_front();
    if (request.scene->truth.noise == Noise::fresh) ++counts_.reused;
  }
  pool.past.push_back(frame);
  while (pool.past.size() > history_of(pool)) pool.past.pop_front();
  if (wanting() != nullptr) changed_.notify_all();
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
