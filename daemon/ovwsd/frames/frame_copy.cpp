#include "daemon/ovwsd/frames/frame_copy.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ovws {

std::int64_t FrameCopy::t_begin_ns() const {
  return t_exposed_mono_ns - std::llround(1e3 * exposure_us);
}

void copy_numbers(const FrameRecord& record, FrameCopy& to) {
  const MeasurementPlan& plan = *record.plan;
  static_cast<FrameStamp&>(to) = record;
  to.frame.image = {};  // goes back to the camera
  to.plan_id = plan.id;
  to.sensor_epoch = plan.sensor_epoch;
  to.charge = plan.charge;
  to.valid = record.valid;
  to.mode_count = record.mode_count;
  const bool all = record.templates.credible || !plan.reconstructor;
  to.measured_count = all ? record.mode_count : int(plan.reconstructor->modes_j().size());
  std::ranges::copy(plan.modes_j, to.modes_j.begin());
  std::copy_n(record.coefficients.begin(), record.mode_count, to.coefficients.begin());
  std::copy_n(record.sigma_waves.begin(), record.mode_count, to.sigma_waves.begin());
  to.correction_count = int(plan.correction.size());
  std::ranges::copy(plan.correction, to.correction.begin());
}

FrameCopy copy_of(const FrameRecord& record) {
  FrameCopy copy;
  copy_numbers(record, copy);
  copy.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  const ImageView& image = record.frame.image;
  const std::size_t bytes = row_bytes(image.format, image.width);
  auto pixels = std::make_shared<std::vector<std::byte>>(bytes * std::size_t(image.height));
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(pixels->data() + std::size_t(y) * bytes, image.row<std::byte>(y), bytes);
  }
  copy.frame.image = image;
  copy.frame.image.data = pixels->data();
  copy.frame.image.stride_bytes = std::ptrdiff_t(bytes);
  copy.pixels = std::move(pixels);
  return copy;
}

FrameFeed::FrameFeed(FrameTaps& taps, std::size_t frames, UsableFrame usable)
    : ring_(frames),
      tap_(taps, FrameTap::Needs::numbers, FrameTap::kEndless,
           [this, usable = std::move(usable)](const FrameRecord& record) {
             if (!usable(record)) return false;
             copy_numbers(record, incoming_);
             return ring_.try_push(incoming_);
           }) {}

std::optional<FrameCopy> FrameInbox::next(std::chrono::milliseconds timeout) {
  if (!tap_) {
    tap_.emplace(taps_, FrameTap::Needs::pixels, 1, [this](const FrameRecord& record) {
      if (!usable_(record)) return false;
      frame_ = copy_of(record);
      return true;
    });
  }
  if (!tap_->wait_for(timeout)) return std::nullopt;
  tap_.reset();
  return std::move(frame_);
}

}  // namespace ovws
