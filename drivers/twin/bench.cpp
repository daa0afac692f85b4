#include "drivers/twin/bench.hpp"

#include <zlib.h>

namespace ovws::twin {
namespace {

constexpr std::size_t kFrameTruths = 32;

}  // namespace

Bench::Bench(const Config& config) : model_(make_optical_model(config)) {
  const SlmGeometry& slm = config.slm.geometry;
  state_.grey = std::make_shared<Image<std::uint8_t>>(slm.width_px, slm.height_px);
  state_.truth = config.truth;
  settle_ = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double, std::milli>(config.slm.settle_ms));
  state_.number = ordered_ = 1;
  last_.truth = config.truth;
}

void Bench::note_change() {
  before_mirror_ = ++state_.number;
  changed_.notify_all();
}

void Bench::show(const Image<std::uint8_t>& grey, Deadline since) {
  const std::lock_guard lock(mutex_);
  const auto& newest = pending_.empty() ? state_.grey : pending_.back().grey;
  if (newest->pixels == grey.pixels) return;
  pending_.push_back({std::make_shared<Image<std::uint8_t>>(grey), since + settle_});
  if (settle_.count() == 0) show_due_images();
  changed_.notify_all();
}

void Bench::show_due_images() {
  const auto now = std::chrono::steady_clock::now();
  while (!pending_.empty() && (settle_.count() == 0 || pending_.front().due <= now)) {
    state_.grey = pending_.front().grey;
    appeared_ = pending_.front().due - settle_;
    pending_.pop_front();
    note_change();
  }
}

void Bench::go_dark() {
  Image<std::uint8_t> dark;
  {
    const std::lock_guard lock(mutex_);
    dark = Image<std::uint8_t>(state_.grey->width, state_.grey->height);
  }
  show(dark, std::chrono::steady_clock::now());
}

Truth Bench::truth() const {
  const std::lock_guard lock(mutex_);
  return state_.truth;
}

std::shared_ptr<const Image<std::uint8_t>> Bench::shown() const {
  const std::lock_guard lock(mutex_);
  return pending_.empty() ? state_.grey : pending_.back().grey;
}

void Bench::set_truth(const Truth& truth) {
  const std::lock_guard lock(mutex_);
  state_.truth = truth;
  note_change();
  ordered_ = state_.number;
}

void Bench::set_mirror(const std::vector<double>& waves) {
  const std::lock_guard lock(mutex_);
  state_.truth.mirror_waves = waves;
  ++state_.number;
  changed_.notify_all();
}

std::uint64_t Bench::begin(const Roi& window, std::int64_t t_ns, std::int64_t period_ns) {
  const std::lock_guard lock(mutex_);
  show_due_images();
  const bool as_expected = next_ns_ != 0 && t_ns >= next_ns_ && t_ns <= next_ns_ + kEarlyMomentNs;
  const std::int64_t moment_ns = as_expected ? next_ns_ : t_ns;
  next_ns_ = 0;
  begun_ns_ = t_ns;
  period_ns_ = period_ns;
  begun_ = std::chrono::steady_clock::now();
  const bool new_moment = state_.truth.turbulence && state_.t_ns != moment_ns;
  state_.t_ns = moment_ns;
  if (state_.window != window || new_moment) {
    state_.window = window;
    note_change();
    ordered_ = state_.number;
  }
  return state_.number;
}

/// Frames begin a whole number of periods apart: the camera leaves out the periods that it misses.
/// A frame may be early or late by half of kEarlyMomentNs.
void Bench::expect_next() {
  if (period_ns_ <= kEarlyMomentNs) return;
  const std::chrono::nanoseconds passed = std::chrono::steady_clock::now() - begun_;
  const std::int64_t until_next_ns = (passed.count() / period_ns_ + 1) * period_ns_;
  next_ns_ = begun_ns_ + until_next_ns - kEarlyMomentNs / 2;
  next_begin_ = begun_ + std::chrono::nanoseconds(until_next_ns);
  changed_.notify_all();
}

/// The SLM's image when the next frame begins, as far as known now.
std::shared_ptr<const Image<std::uint8_t>> Bench::next_grey() const {
  auto grey = state_.grey;
  for (const PendingImage& image : pending_) {
    if (image.due <= next_begin_) grey = image.grey;
  }
  return grey;
}

bool Bench::preparation_wanted() const {
  return !pending_.empty() && pending_.front().grey != prepared_;
}

bool Bench::ahead_wanted() const {
  return state_.truth.turbulence && next_ns_ != 0 &&
         (last_.t_ns != next_ns_ || last_.grey != next_grey());
}

/// Whether a frame of `scene_` may be sent. Changes of truth or window take effect at once, so a
/// frame computed before them is never sent. Display changes allow kStaleFrameTime.
bool Bench::may_be_sent() const {
  if (computed_ == state_.number) return true;
  return computed_ >= ordered_ && std::chrono::steady_clock::now() < appeared_ + kStaleFrameTime;
}

/// Whether nothing but the mirror has changed since this scene, of a frame that began at `begun`.
bool Bench::unchanged_but_mirror(const Scene* scene, std::uint64_t begun) const {
  return scene != nullptr && scene->number >= begun && scene->number >= before_mirror_;
}

std::shared_ptr<const Scene> Bench::scene(std::uint64_t begun,
                                          const std::shared_ptr<const Scene>& ready,
                                          Deadline deadline, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const bool ready_in_time = changed_.wait_until(lock, stop, deadline, [&] {
    return unchanged_but_mirror(ready.get(), begun) ||
           (computed_ >= begun && (scene_ != ready || may_be_sent()));
  });
  if (!ready_in_time) return nullptr;
  return unchanged_but_mirror(ready.get(), begun) ? ready : scene_;
}

void Bench::note_sent(std::uint64_t frame_id, std::int64_t t_device_ns, const Scene& scene) {
  const std::lock_guard lock(mutex_);
  frame_truths_.push_back({frame_id, t_device_ns, scene.crc32, scene.turbulence});
  if (frame_truths_.size() > kFrameTruths) frame_truths_.pop_front();
  if (scene.truth.turbulence) expect_next();
}

std::vector<FrameTruth> Bench::frame_truths() const {
  const std::lock_guard lock(mutex_);
  return {frame_truths_.begin(), frame_truths_.end()};
}

BenchStatus Bench::status() const {
  const std::lock_guard lock(mutex_);
  BenchStatus status = status_;
  status.changes = state_.number;
  return status;
}

/// Moves the turbulence to the time `now.t_ns`; returns whether its wavefront has changed.
bool Bench::update_turbulence(const State& now) {
  const std::optional<TurbulenceConfig>& wanted = now.truth.turbulence;
  if (!wanted && !turbulence_) return false;
  const bool same = wanted && turbulence_ && turbulence_->config() == *wanted;
  if (same && now.t_ns == last_.t_ns) return false;
  if (!wanted) {
    turbulence_.reset();
  } else if (!same) {
    turbulence_.emplace(*wanted);
  }
  model_->set_turbulence(turbulence_ ? &*turbulence_ : nullptr, now.t_ns);
  return true;
}

std::shared_ptr<const Scene> Bench::compute(const State& now) {
  const bool light_changed =
      static_cast<const Light&>(now.truth) != static_cast<const Light&>(last_.truth);
  const bool window_changed =
      now.window != last_.window || now.truth.geometry != last_.truth.geometry;
  if (light_changed) model_->set_light(now.truth);
  if (window_changed) model_->set_window(*now.window, now.truth.geometry);
  const bool turbulence_changed = update_turbulence(now);
  if (light_changed || window_changed || turbulence_changed || now.grey != last_.grey) {
    last_intensity_ = std::make_shared<Image<float>>(model_->intensity(*now.grey));
  }
  if (now.grey != last_.grey || last_crc32_ == 0) {
    const auto& pixels = now.grey->pixels;
    last_crc32_ = std::uint32_t(::crc32(0, pixels.data(), uInt(pixels.size())));
  }
  last_ = now;
  Scene scene{last_intensity_, now.truth, now.t_ns, last_crc32_, {}, now.number};
  if (turbulence_) scene.turbulence = turbulence_->modes(now.t_ns);
  return std::make_shared<Scene>(std::move(scene));
}

void Bench::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const auto something = [this] {
    return state_.window && (computed_ != state_.number || preparation_wanted() || ahead_wanted());
  };
  while (changed_.wait(lock, stop, something)) {
    if (computed_ != state_.number) {
      compute_now(lock);
    } else if (preparation_wanted()) {
      prepare_next(lock);
    } else {
      compute_ahead(lock);
    }
  }
}

/// Computes with the mutex unlocked.
std::shared_ptr<const Scene> Bench::compute_unlocked(const State& now,
                                                     std::unique_lock<std::mutex>& lock) {
  lock.unlock();
  const auto start = std::chrono::steady_clock::now();
  const auto intensity_before = last_intensity_;
  auto scene = compute(now);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  lock.lock();
  if (last_intensity_ != intensity_before) {
    ++status_.far_fields;
    status_.far_field_ms = took.count();
  }
  return scene;
}

void Bench::compute_now(std::unique_lock<std::mutex>& lock) {
  const State now = state_;
  scene_ = compute_unlocked(now, lock);
  computed_ = now.number;
  changed_.notify_all();
}

/// Computes the next frame's light, which `compute` then finds unless the state changes.
void Bench::compute_ahead(std::unique_lock<std::mutex>& lock) {
  State next = state_;
  next.grey = next_grey();
  next.t_ns = next_ns_;
  compute_unlocked(next, lock);
}

/// Prepares the image that the liquid crystal turns to, while it does.
void Bench::prepare_next(std::unique_lock<std::mutex>& lock) {
  prepared_ = pending_.front().grey;
  const auto next = prepared_;
  lock.unlock();
  if (last_.window) model_->prepare(*next);
  lock.lock();
}

}  // namespace ovws::twin
