#include "drivers/twin/bench.hpp"

namespace ovws::twin {

Bench::Bench(const Config& config) : model_(config) {
  const SlmGeometry& slm = config.slm.geometry;
  state_.grey = std::make_shared<Image<std::uint8_t>>(slm.width_px, slm.height_px);
  state_.truth = config.truth;
  state_.number = 1;
  last_.truth = config.truth;
}

void Bench::show(const Image<std::uint8_t>& grey) {
  const std::lock_guard lock(mutex_);
  if (state_.grey->pixels == grey.pixels) return;
  state_.grey = std::make_shared<Image<std::uint8_t>>(grey);
  ++state_.number;
  changed_.notify_all();
}

void Bench::go_dark() {
  Image<std::uint8_t> dark;
  {
    const std::lock_guard lock(mutex_);
    dark = Image<std::uint8_t>(state_.grey->width, state_.grey->height);
  }
  show(dark);
}

Truth Bench::truth() const {
  const std::lock_guard lock(mutex_);
  return state_.truth;
}

void Bench::set_truth(const Truth& truth) {
  const std::lock_guard lock(mutex_);
  state_.truth = truth;
  ++state_.number;
  changed_.notify_all();
}

std::shared_ptr<const Scene> Bench::scene(const Roi& window, Deadline deadline,
                                          const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (state_.window != window) {
    state_.window = window;
    ++state_.number;
    changed_.notify_all();
  }
  const bool current =
      changed_.wait_until(lock, stop, deadline, [this] { return computed_ == state_.number; });
  return current ? scene_ : nullptr;
}

BenchStatus Bench::status() const {
  const std::lock_guard lock(mutex_);
  BenchStatus status = status_;
  status.changes = state_.number;
  return status;
}

std::shared_ptr<const Scene> Bench::compute(const State& now) {
  const bool aberration_changed = now.truth.aberration != last_.truth.aberration;
  const bool window_changed = now.window != last_.window;
  if (aberration_changed) model_.set_aberration(now.truth.aberration);
  if (window_changed) model_.set_window(*now.window);
  if (aberration_changed || window_changed || now.grey != last_.grey) {
    last_intensity_ = std::make_shared<Image<float>>(model_.intensity(*now.grey));
  }
  last_ = now;
  return std::make_shared<Scene>(Scene{last_intensity_, now.truth});
}

void Bench::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (
      changed_.wait(lock, stop, [this] { return state_.window && computed_ != state_.number; })) {
    const State now = state_;
    lock.unlock();
    const auto start = std::chrono::steady_clock::now();
    const auto intensity_before = last_intensity_;
    auto scene = compute(now);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    lock.lock();
    scene_ = std::move(scene);
    computed_ = now.number;
    if (last_intensity_ != intensity_before) {
      ++status_.far_fields;
      status_.far_field_ms = took.count();
    }
    changed_.notify_all();
  }
}

}  // namespace ovws::twin
