#include "daemon/ovwsd/frames/image_brightness.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>

#include "core/base/pixels.hpp"
#include "proto/dark_image.hpp"

namespace ovws {
namespace {

constexpr int kBrightPixels = 16;
constexpr int kLevels = 1024;
constexpr std::int64_t kMaxAgeNs = 3'000'000'000;

}  // namespace

double brightest_fraction(const ImageView& image) {
  const double full = full_scale_dn(image.format);
  const float scale = float((kLevels - 1) / full);
  std::array<int, kLevels> counts{};
  visit_rows(image, 0, 0, image.width, image.height, [&](int, int, const auto* pixels, int count) {
    for (int i = 0; i < count; ++i) {
      ++counts[std::size_t(std::min(kLevels - 1, int(scale * float(pixels[i]) + 0.5F)))];
    }
  });
  int above = 0, level = kLevels - 1;
  while (level > 0 && (above += counts[std::size_t(level)]) < kBrightPixels) --level;
  return double(level) / (kLevels - 1);
}

std::string dark_text(double fraction) {
  return fmt::format("the image is dark, its brightest pixels reach {:.1f} % of full scale: {}",
                     100.0 * fraction, dark_advice("run camera.auto_exposure"));
}

void ImageBrightness::look(const ImageView& image, std::int64_t now_ns) {
  fraction_.store(brightest_fraction(image), std::memory_order_relaxed);
  t_ns_.store(now_ns, std::memory_order_relaxed);
}

std::optional<double> ImageBrightness::newest(std::int64_t now_ns) const {
  const std::int64_t t_ns = t_ns_.load(std::memory_order_relaxed);
  if (t_ns < now_ns - kMaxAgeNs) return std::nullopt;
  return fraction_.load(std::memory_order_relaxed);
}

}  // namespace ovws
