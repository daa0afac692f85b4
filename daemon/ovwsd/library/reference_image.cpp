#include "daemon/ovwsd/library/reference_image.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/pixels.hpp"

namespace ovws {
namespace {

constexpr float kFull16 = 65535.0F;

void add_to(const ImageView& image, ReferenceImage& picture) {
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

double to_16_bits(PixelFormat format) {
  return double(kFull16) / full_scale_dn(format);
}

Image<std::uint16_t> in_16_bits(const Image<float>& mean_dn, PixelFormat format) {
  Image<std::uint16_t> scaled(mean_dn.width, mean_dn.height);
  const auto scale = float(to_16_bits(format));
  std::transform(mean_dn.pixels.begin(), mean_dn.pixels.end(), scaled.pixels.begin(),
                 [scale](float dn) {
                   const float value = scale * dn;
                   return value < kFull16 ? std::uint16_t(std::max(0.0F, value) + 0.5F)
                                          : std::uint16_t(kFull16);
                 });
  return scaled;
}

bool ImageMean::add(const FrameRecord& record) {
  const ImageView& image = record.frame.image;
  if (sum_.frames == 0) {
    sum_.gain_db = record.gain_db;
    sum_.gain_raw = record.gain_raw;
    sum_.format = image.format;
    sum_.mean_dn = Image<float>(image.width, image.height);
  }
  const bool same = image.width == sum_.mean_dn.width && image.height == sum_.mean_dn.height &&
                    image.format == sum_.format && same_number(record.gain_db, sum_.gain_db) &&
                    same_number(record.gain_raw, sum_.gain_raw);
  if (same) add_to(image, sum_);
  return same;
}

std::shared_ptr<const ReferenceImage> ImageMean::mean() {
  if (sum_.frames == 0) return nullptr;
  for (float& pixel : sum_.mean_dn.pixels) pixel /= float(sum_.frames);
  return std::make_shared<const ReferenceImage>(std::move(sum_));
}

}  // namespace ovws
