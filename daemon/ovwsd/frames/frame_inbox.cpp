#include "daemon/ovwsd/frames/frame_inbox.hpp"

#include <cstring>

namespace ovws {
namespace {

void copy_pixels(const ImageView& image, FrameCopy& to) {
  const std::size_t bytes = row_bytes(image.format, image.width);
  to.pixels.resize(bytes * std::size_t(image.height));
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(to.pixels.data() + std::size_t(y) * bytes, image.row<std::byte>(y), bytes);
  }
  to.image = image;
  to.image.data = to.pixels.data();
  to.image.stride_bytes = std::ptrdiff_t(bytes);
}

}  // namespace

bool can_be_refined(const FrameRecord& record) {
  return record.settled && record.settings_known && (record.valid || !record.plan->referenced());
}

void FrameInbox::forget() {
  const std::lock_guard lock(mutex_);
  state_ = State::idle;
}

const FrameCopy* FrameInbox::next(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (state_ == State::idle) state_ = State::asked;
  if (!filled_.wait_for(lock, timeout, [this] { return state_ == State::filled; })) return nullptr;
  state_ = State::idle;
  return &frame_;
}

bool FrameInbox::wants() {
  const std::lock_guard lock(mutex_);
  return state_ == State::asked;
}

void FrameInbox::take(const FrameRecord& record) {
  if (!usable_(record)) return;
  const std::lock_guard lock(mutex_);
  if (state_ != State::asked) return;
  frame_.frame_id = record.frame.frame_id;
  frame_.hologram_id = record.hologram_id;
  frame_.plan_id = record.plan->id;
  frame_.t_arrival_ns = record.frame.t_arrival_ns;
  frame_.charge = record.plan->charge;
  frame_.gain_db = record.gain_db;
  frame_.gain_raw = record.gain_raw;
  frame_.exposure_us = record.exposure_us;
  frame_.valid = record.valid;
  frame_.coefficients.assign(record.coefficients.begin(),
                             record.coefficients.begin() + record.mode_count);
  frame_.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  copy_pixels(record.frame.image, frame_);
  state_ = State::filled;
  filled_.notify_one();
}

}  // namespace ovws
