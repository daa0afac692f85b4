#include "drivers/twin/bench.hpp"

#include <zlib.h>

#include <algorithm>

#include "drivers/twin/glib_hooks.hpp"

namespace ovws::twin {
namespace {

constexpr std::size_t kFrameTruths = 16384;
constexpr std::size_t kLastTruths = 32, kTruthsAfter = 2048;  // in one answer
constexpr int kFrameIds = 65535;                              // on the wire
static_assert(kFrameTruths < kFrameIds / 2, "a frame number before another is not one after it");

std::uint32_t crc32_of(const Image<std::uint8_t>& grey) {
  return std::uint32_t(::crc32(0, grey.pixels.data(), uInt(grey.pixels.size())));
}

}  // namespace

Bench::Bench(const Config& config)
    : clock_(config.dmd.patterns > 0 ? std::optional<PatternClock>(config.dmd) : std::nullopt),
      model_(make_optical_model(config)) {
  const SlmGeometry& slm = config.slm.geometry;
  state_.shown = std::make_shared<Patterns>(dark_patterns(config.dmd, slm.width_px, slm.height_px));
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

/// When an image that appeared at `since` takes effect. In pattern mode half a pattern before the
/// first pulse of a cycle, so that every pulse is clearly before or after it.
Bench::Deadline Bench::effect_of(Deadline since) const {
  const Deadline settled = since + settle_;
  if (!clock_) return settled;
  const std::chrono::nanoseconds from_now = settled - std::chrono::steady_clock::now();
  const std::int64_t settled_ns = twin_ns() + from_now.count();
  const std::int64_t wait_ns = clock_->next_cycle(settled_ns) - settled_ns;
  return settled + std::chrono::nanoseconds(wait_ns - std::int64_t(clock_->period_ns() / 2));
}

void Bench::show(const Patterns& patterns, Deadline since) {
  const std::lock_guard lock(mutex_);
  const auto& newest = pending_.empty() ? state_.shown : pending_.back().patterns;
  if (same_pixels(*newest, patterns)) return;
  pending_.push_back({std::make_shared<Patterns>(patterns), effect_of(since)});
  show_due_images(std::chrono::steady_clock::now() - kKeptImageTime);
  changed_.notify_all();
}

void Bench::show_due_images(Deadline at) {
  while (!pending_.empty() && (takes_effect_at_once() || pending_.front().due <= at)) {
    state_.shown = pending_.front().patterns;
    appeared_ = pending_.front().due - settle_;
    pending_.pop_front();
    note_change();
  }
}

void Bench::go_dark() {
  Patterns dark;
  {
    const std::lock_guard lock(mutex_);
    dark = *state_.shown;
  }
  for (auto& pattern : dark) pattern = Image<std::uint8_t>(pattern.width, pattern.height);
  show(dark, std::chrono::steady_clock::now());
}

Truth Bench::truth() const {
  const std::lock_guard lock(mutex_);
  return state_.truth;
}

std::shared_ptr<const Patterns> Bench::shown() const {
  const std::lock_guard lock(mutex_);
  return pending_.empty() ? state_.shown : pending_.back().patterns;
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

std::uint64_t Bench::begin(const Roi& window, std::int64_t t_ns, std::int64_t period_ns,
                           const Exposed& exposed) {
  const std::lock_guard lock(mutex_);
  begun_ = std::chrono::steady_clock::now();
  // In pattern mode the frame's own time counts: its pulse may have come some time ago.
  show_due_images(clock_ ? begun_ + std::chrono::nanoseconds(t_ns - twin_ns()) : begun_);
  const bool as_expected = next_ns_ != 0 && t_ns >= next_ns_ && t_ns <= next_ns_ + kEarlyMomentNs;
  const std::int64_t moment_ns = as_expected ? next_ns_ : t_ns;
  next_ns_ = 0;
  begun_ns_ = t_ns;
  period_ns_ = period_ns;
  const bool new_moment = state_.truth.turbulence && state_.t_ns != moment_ns;
  state_.t_ns = moment_ns;
  state_.exposed = exposed;
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
std::shared_ptr<const Patterns> Bench::next_shown() const {
  auto shown = state_.shown;
  for (const PendingImage& image : pending_) {
    if (image.due <= next_begin_) shown = image.patterns;
  }
  return shown;
}

bool Bench::preparation_wanted() const {
  return !pending_.empty() && pending_.front().patterns != prepared_;
}

bool Bench::ahead_wanted() const {
  return state_.truth.turbulence && next_ns_ != 0 &&
         (last_.t_ns != next_ns_ || last_.shown != next_shown());
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
  const Exposed& exposed = state_.exposed;
  frame_truths_.push_back(
      {frame_id, t_device_ns, scene.patterns[std::size_t(exposed.first)].crc32,
       clock_ && exposed.count == 1 ? std::optional(exposed.first) : std::nullopt,
       scene.turbulence});
  if (frame_truths_.size() > kFrameTruths) frame_truths_.pop_front();
  if (scene.truth.turbulence) expect_next();
}

std::vector<FrameTruth> Bench::frame_truths(std::optional<int> after) const {
  const std::lock_guard lock(mutex_);
  const auto newest = frame_truths_.end();
  if (!after) return {newest - std::ptrdiff_t(std::min(frame_truths_.size(), kLastTruths)), newest};
  const auto is_later = [after](const FrameTruth& frame) {
    const int later = (int(frame.frame_id) - *after + kFrameIds) % kFrameIds;
    return later > 0 && later <= kFrameIds / 2;
  };
  // From the newest backwards: frame numbers start again when a camera is plugged in.
  const auto first =
      std::find_if_not(frame_truths_.rbegin(), frame_truths_.rend(), is_later).base();
  return {first, first + std::min(newest - first, std::ptrdiff_t(kTruthsAfter))};
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

/// With turbulence every frame has light of its own, so only what it exposes is computed.
void Bench::compute_light(const State& now) {
  const std::size_t patterns = last_light_.size();
  const std::size_t first = turbulence_ ? std::size_t(now.exposed.first) : 0;
  const std::size_t count = turbulence_ ? std::size_t(now.exposed.count) : patterns;
  for (std::size_t n = first; n < first + count; ++n) {
    PatternLight& light = last_light_[n % patterns];
    if (light.intensity != nullptr) continue;
    light.intensity = std::make_shared<Image<float>>(model_->intensity((*now.shown)[n % patterns]));
    ++computed_light_;
  }
}

std::shared_ptr<const Scene> Bench::compute(const State& now) {
  const bool light_changed =
      static_cast<const Light&>(now.truth) != static_cast<const Light&>(last_.truth);
  const bool window_changed =
      now.window != last_.window || now.truth.geometry != last_.truth.geometry;
  if (light_changed) model_->set_light(now.truth);
  if (window_changed) model_->set_window(*now.window, now.truth.geometry);
  const bool turbulence_changed = update_turbulence(now);
  if (now.shown != last_.shown) {
    last_light_.clear();
    for (const auto& image : *now.shown) last_light_.push_back({nullptr, crc32_of(image)});
  } else if (light_changed || window_changed || turbulence_changed) {
    for (PatternLight& light : last_light_) light.intensity = nullptr;
  }
  last_ = now;
  compute_light(now);
  Scene scene{last_light_, now.truth, now.t_ns, {}, now.number};
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
  const std::uint64_t computed_before = computed_light_;
  auto scene = compute(now);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  lock.lock();
  const std::uint64_t computed = computed_light_ - computed_before;
  if (computed > 0) {
    status_.far_fields += computed;
    status_.far_field_ms = took.count() / double(computed);
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
  next.shown = next_shown();
  next.t_ns = next_ns_;
  compute_unlocked(next, lock);
}

/// Prepares the image that takes effect next: all light of several patterns, else what does not
/// depend on the turbulence.
void Bench::prepare_next(std::unique_lock<std::mutex>& lock) {
  prepared_ = pending_.front().patterns;
  State next = state_;
  next.shown = prepared_;
  if (prepared_->size() > 1 && !state_.truth.turbulence) {
    compute_unlocked(next, lock);
    return;
  }
  lock.unlock();
  if (last_.window) model_->prepare(next.shown->front());
  lock.lock();
}

}  // namespace ovws::twin
