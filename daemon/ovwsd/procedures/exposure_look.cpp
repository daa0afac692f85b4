#include "daemon/ovwsd/procedures/exposure_look.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace ovws {
namespace {

constexpr double kSignificance = 6.0;  // of light, in standard deviations of the background
constexpr double kDarkShare = 0.05;    // fraction of the pixels that are darker than `dark`
constexpr double kHotContrast = 10.0;  // a hot pixel exceeds all its neighbours by this factor
constexpr double kResolvedPx = 1.5;    // narrower spots may look like hot pixels
constexpr std::size_t kMaxHot = 256;   // hot pixels that are left out at most

float or_full(float dn, double full) {
  return std::isnan(dn) ? float(full) : dn;
}

/// Whether pixel `at` is much brighter than each of its neighbours.
bool is_hot(const Image<float>& image, std::size_t at, double dark, double full) {
  const int x = int(at % std::size_t(image.width)), y = int(at / std::size_t(image.width));
  double nearest = 0.0;
  for (int j = std::max(0, y - 1); j <= std::min(image.height - 1, y + 1); ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(image.width - 1, x + 1); ++i) {
      if (i != x || j != y)
        nearest = std::max(nearest, double(or_full(image.at(i, j), full)) - dark);
    }
  }
  return double(or_full(image.pixels[at], full)) - dark > kHotContrast * std::max(nearest, 1e-9);
}

/// The value that this share of the pixels does not exceed.
float quantile(std::vector<float>& values, double share) {
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

ExpectedSpots expected_spots(const SensorSnapshot& now, const SlmGeometry& slm,
                             const LitPixels& lit) {
  const double spot_px = lambda_d_px(now.optics, slm, now.sensor) / lit.plane.step;
  if (now.pattern == HologramKind::sensor) return {now.subapertures, spot_px >= kResolvedPx};
  const double whole_px = spot_px / now.sensor.subapertures_across;  // the whole pupil's spot
  return {1, whole_px >= kResolvedPx};
}

ExposureLook judge_exposure(const Image<float>& image, const ExpectedSpots& expected,
                            const CameraSettings& settings) {
  ExposureLook look;
  look.settings = settings;
  look.full = full_scale_dn(settings.pixel_format);
  std::vector<float> values(image.pixels.size());
  std::transform(image.pixels.begin(), image.pixels.end(), values.begin(),
                 [&](float dn) { return or_full(dn, look.full); });
  look.saturated_pixels = int(std::count_if(image.pixels.begin(), image.pixels.end(),
                                            [](float dn) { return std::isnan(dn); }));
  look.dark = double(quantile(values, kDarkShare));
  const float median = quantile(values, 0.5);
  std::vector<std::uint32_t> order(image.pixels.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto value_at = [&](std::uint32_t i) { return or_full(image.pixels[i], look.full); };
  const std::size_t top = std::min(order.size(), std::size_t(expected.count) + kMaxHot);
  std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(top), order.end(),
                    [&](std::uint32_t a, std::uint32_t b) { return value_at(a) > value_at(b); });
  int left = expected.count;
  for (std::size_t k = 0; k < top && left > 0; ++k) {
    if (expected.resolved && is_hot(image, order[k], look.dark, look.full)) continue;
    look.brightest = double(value_at(order[k]));
    --left;
  }
  for (float& value : values) value = std::abs(value - median);
  const double noise = 1.4826 * double(quantile(values, 0.5));  // of a normal distribution
  look.lit = look.brightest - double(median) > std::max(1.0, kSignificance * noise);
  if (look.brightest >= look.full) look.brightest = NAN;
  return look;
}

}  // namespace ovws
