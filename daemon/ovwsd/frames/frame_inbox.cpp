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

void copy_frame(const FrameRecord& record, FrameCopy& to) {
  to.frame_id = record.frame.frame_id;
  to.hologram_id = record.hologram_id;
  to.plan_id = record.plan->id;
  to.sensor_epoch = record.plan->sensor_epoch;
  to.t_arrival_ns = record.frame.t_arrival_ns;
  to.charge = record.plan->charge;
  to.gain_db = record.gain_db;
  to.gain_raw = record.gain_raw;
  to.exposure_us = record.exposure_us;
  to.valid = record.valid;
  to.coefficients.assign(record.coefficients.begin(),
                         record.coefficients.begin() + record.mode_count);
  to.spots.assign(record.spots.begin(), record.spots.begin() + record.spot_count);
  copy_pixels(record.frame.image, to);
}

}  // namespace

FrameCopy copy_of(const FrameCopy& frame) {
  FrameCopy copy = frame;
  copy.image.data = copy.pixels.data();
  return copy;
}

bool can_be_refined(const FrameRecord& record) {
  return record.settled && record.pattern < 0 && record.settings_known &&
         (record.valid || !record.plan->referenced());
}

const FrameCopy* FrameInbox::next(std::chrono::milliseconds timeout) {
  if (!request_) {
    const auto take = [this](const FrameRecord& record) {
      if (!usable_(record)) return false;
      copy_frame(record, frame_);
      return true;
    };
    request_ = broker_.request(FrameBroker::Needs::pixels, 1, take);
  }
  if (!request_->wait_for(timeout)) return nullptr;
  request_.reset();
  return &frame_;
}

}  // namespace ovws
