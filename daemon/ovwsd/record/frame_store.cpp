#include "daemon/ovwsd/record/frame_store.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>

namespace ovws {
namespace {

RecordedFrame row_of(const FrameRecord& record) {
  RecordedFrame row;
  row.frame_id = record.frame.frame_id;
  row.gap = record.gap;
  row.hologram_id = record.hologram_id;
  row.plan_id = record.plan->id;
  row.t_device_ns = record.frame.t_device_ns;
  row.t_arrival_ns = record.frame.t_arrival_ns;
  row.t_arrival_mono_ns = record.frame.t_arrival_mono_ns;
  row.t_tracked_mono_ns = record.t_tracked_mono_ns;
  row.t_reconstructed_mono_ns = record.t_reconstructed_mono_ns;
  if (record.settings_known) {
    row.gain_db = record.gain_db;
    row.gain_raw = record.gain_raw;
    row.exposure_us = record.exposure_us;
  }
  row.fit_residual_px = record.reconstruction.fit_residual_px;
  row.rms_waves = record.reconstruction.rms_waves;
  row.saturated = record.saturated_fraction;
  row.tracked = std::uint32_t(record.tracked);
  row.still = record.still;
  row.settled = record.settled;
  row.settings_known = record.settings_known;
  row.determined = record.reconstruction.determined;
  row.explained = record.explained;
  row.valid = record.valid;
  row.searched = record.searched;
  for (std::size_t k = 0; k < record.beams().size(); ++k) {
    if (record.beams()[k]->searched) row.searched |= std::uint8_t(2U << k);
  }
  row.left_justified_bits = std::uint8_t(record.frame.image.left_justified_bits);
  return row;
}

void add_spots(const FrameRecord& record, std::vector<RecordedSpot>& to) {
  for (int i = 0; i < record.spot_count; ++i) {
    const SpotFix& fix = record.spots[std::size_t(i)];
    const SpotStart& start = record.starts[std::size_t(i)];
    to.push_back({fix.x, fix.y, fix.peak, fix.quality, fix.level, fix.noise, start.at_px.x,
                  start.at_px.y, start.fresh});
  }
}

}  // namespace

FrameStore::FrameStore(std::size_t pictures, std::size_t image_bytes)
    : frames_(kMaxFrames),
      pictures_(pictures),
      image_bytes_(image_bytes),
      free_frames_(kMaxFrames),
      full_(kMaxFrames),
      free_images_(std::max<std::size_t>(pictures, 1)) {
  for (TakenFrame& frame : frames_) (void)free_frames_.try_push(&frame);
  for (std::size_t p = 0; p < pictures; ++p) {
    memory_.push_back(std::make_unique<std::byte[]>(image_bytes));
    (void)free_images_.try_push(memory_.back().get());
  }
}

void FrameStore::take(const FrameRecord& record, bool with_image) {
  if (first_number_ == 0) first_number_ = record.number;
  last_number_ = record.number;
  TakenFrame* frame = nullptr;
  if (!free_frames_.try_pop(frame)) return;
  frame->row = row_of(record);
  frame->number = record.number;
  frame->spots.clear();
  add_spots(record, frame->spots);
  frame->beam_spots.clear();
  for (const FrameRecord* const beam : record.beams()) add_spots(*beam, frame->beam_spots);
  frame->coefficients.assign(record.coefficients.begin(),
                             record.coefficients.begin() + record.mode_count);
  frame->sigma_waves.assign(record.sigma_waves.begin(),
                            record.sigma_waves.begin() + record.mode_count);
  frame->pixels = {};
  if (with_image) copy_image(record.frame.image, *frame);
  frame->row.picture_dropped =
      record.pixels_missed || (with_image && frame->pixels.empty()) ? 1 : 0;
  (void)full_.try_push(frame);  // never full: it has room for all frames
}

void FrameStore::copy_image(const ImageView& image, TakenFrame& to) {
  const std::size_t bytes = row_bytes(image.format, image.width);
  std::byte* picture = nullptr;
  if (bytes * std::size_t(image.height) != image_bytes_) return;  // another size than the file's
  if (!free_images_.try_pop(picture)) return;
  to.pixels = {picture, image_bytes_};
  for (int y = 0; y < image.height; ++y) {
    std::memcpy(picture + std::size_t(y) * bytes, image.row<std::byte>(y), bytes);
  }
}

TakenFrame* FrameStore::next(int timeout_us) {
  TakenFrame* frame = nullptr;
  return full_.pop(frame, std::chrono::microseconds(timeout_us)) ? frame : nullptr;
}

std::uint64_t FrameStore::taken_after(std::uint64_t number) const {
  if (last_number_ == 0) return 0;
  return number == 0 ? last_number_ - first_number_ + 1 : last_number_ - number;
}

void FrameStore::give_back(TakenFrame* frame) {
  if (!frame->pixels.empty()) (void)free_images_.try_push(frame->pixels.data());
  (void)free_frames_.try_push(frame);
}

}  // namespace ovws
