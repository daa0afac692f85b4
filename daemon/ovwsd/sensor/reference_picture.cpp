#include "daemon/ovwsd/sensor/reference_picture.hpp"

#include <cmath>
#include <utility>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

void add_to(const ImageView& image, ReferencePicture& picture) {
  const auto full = float(full_scale_dn(image.format));
  visit_rows(image, 0, 0, image.width, image.height,
             [&](int x, int y, const auto* pixels, int count) {
               float* const to = picture.mean_dn.row(y) + x;
               for (int i = 0; i < count; ++i) {
                 const auto value = float(pixels[i]);
                 to[i] += value < full ? value : NAN;
               }
             });
  ++picture.frames;
}

}  // namespace

ReferencePicture picture_of(const ImageView& image) {
  ReferencePicture picture;
  picture.format = image.format;
  picture.mean_dn = Image<float>(image.width, image.height);
  add_to(image, picture);
  return picture;
}

void ReferencePictureTaker::begin(std::uint64_t sensor_epoch, std::uint64_t hologram_id, int most) {
  const std::lock_guard lock(mutex_);
  sensor_epoch_ = sensor_epoch;
  hologram_id_ = hologram_id;
  most_ = most;
  sum_ = std::make_unique<ReferencePicture>();
}

std::shared_ptr<const ReferencePicture> ReferencePictureTaker::end() {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<ReferencePicture> made = std::exchange(sum_, nullptr);
  if (!made || made->frames == 0) return nullptr;
  for (float& pixel : made->mean_dn.pixels) pixel /= float(made->frames);
  return made;
}

int ReferencePictureTaker::frames() {
  const std::lock_guard lock(mutex_);
  return sum_ ? sum_->frames : 0;
}

bool ReferencePictureTaker::wants() {
  const std::lock_guard lock(mutex_);
  return sum_ && sum_->frames < most_;
}

void ReferencePictureTaker::take(const FrameRecord& record) {
  const std::lock_guard lock(mutex_);
  if (!sum_ || sum_->frames == most_ || !record.still || !record.settings_known) return;
  if (record.plan->sensor_epoch != sensor_epoch_ || record.hologram_id != hologram_id_) return;
  const ImageView& image = record.frame.image;
  if (sum_->frames == 0) {
    sum_->gain_db = record.gain_db;
    sum_->gain_raw = record.gain_raw;
    sum_->format = image.format;
    sum_->mean_dn = Image<float>(image.width, image.height);
  }
  const bool same = image.width == sum_->mean_dn.width && image.height == sum_->mean_dn.height &&
                    image.format == sum_->format && same_number(record.gain_db, sum_->gain_db) &&
                    same_number(record.gain_raw, sum_->gain_raw);
  if (!same) return;
  add_to(image, *sum_);
}

}  // namespace ovws
