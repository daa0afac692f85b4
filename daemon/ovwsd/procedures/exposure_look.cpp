#include "daemon/ovwsd/procedures/exposure_look.hpp"

#include <algorithm>
#include <vector>

namespace ovws {
namespace {

constexpr double kSignificance = 6.0;  // of light, in standard deviations of the background
constexpr double kDarkShare = 0.05;    // fraction of the pixels that are darker than `dark`
constexpr double kHotContrast = 10.0;  // a hot pixel exceeds all its neighbours by this factor
constexpr double kResolvedPx = 1.5;    // narrower spots may look like hot pixels
constexpr double kPercentile = 0.8;    // of the spots' brightest pixels
constexpr double kApart = 1.5;         // lambda/d between peaks of two spots

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

struct Peak {
  double dn = 0.0;
  int x = 0, y = 0;
};

/// The brightest pixel of each tile of the image, without hot pixels.
std::vector<Peak> tile_peaks(const Image<float>& image, int side, bool skip_hot, double dark,
                             double full) {
  std::vector<Peak> peaks;
  for (int top = 0; top < image.height; top += side) {
    for (int left = 0; left < image.width; left += side) {
      Peak best{-1.0};
      for (int y = top; y < std::min(top + side, image.height); ++y) {
        for (int x = left; x < std::min(left + side, image.width); ++x) {
          const double dn = or_full(image.at(x, y), full);
          if (dn <= best.dn) continue;
          const std::size_t at = std::size_t(y) * image.width + x;
          if (!skip_hot || !is_hot(image, at, dark, full)) best = {dn, x, y};
        }
      }
      if (best.dn >= 0.0) peaks.push_back(best);
    }
  }
  return peaks;
}

/// As many peaks as there are spots, the brightest first, kApart apart.
std::vector<Peak> brightest_peaks(const Image<float>& image, const ExpectedSpots& expected,
                                  double dark, double full) {
  const double apart_px = std::max(1.0, kApart * expected.size_px);
  auto all =
      tile_peaks(image, int(std::ceil(apart_px)), expected.size_px >= kResolvedPx, dark, full);
  std::sort(all.begin(), all.end(), [](const Peak& a, const Peak& b) { return a.dn > b.dn; });
  std::vector<Peak> found;
  for (const Peak& peak : all) {
    if (int(found.size()) == expected.count) break;
    const bool is_near = std::any_of(found.begin(), found.end(), [&](const Peak& other) {
      return std::hypot(peak.x - other.x, peak.y - other.y) < apart_px;
    });
    if (!is_near) found.push_back(peak);
  }
  return found;
}

}  // namespace

ExpectedSpots expected_spots(const SensorSnapshot& now, const SlmGeometry& slm,
                             const LitPixels& lit) {
  const double spot_px = lambda_d_px(now.optics, slm, now.sensor) / lit.plane.step;
  if (now.pattern == HologramKind::sensor) return {now.subapertures, spot_px};
  return {1, spot_px / now.sensor.subapertures_across};  // the whole pupil's spot
}

ExposureLook judge_exposure(const Image<float>& image, const ExpectedSpots& expected,
                            const CameraSettings& settings) {
  ExposureLook look;
  look.settings = settings;
  look.full = full_scale_dn(settings.pixel_format);
  look.saturated_pixels = int(std::count_if(image.pixels.begin(), image.pixels.end(),
                                            [](float dn) { return std::isnan(dn); }));
  std::vector<float> values(image.pixels.size());
  std::transform(image.pixels.begin(), image.pixels.end(), values.begin(),
                 [&](float dn) { return or_full(dn, look.full); });
  look.dark = double(quantile(values, kDarkShare));
  const float median = quantile(values, 0.5);
  for (float& value : values) value = std::abs(value - median);
  const double noise = 1.4826 * double(quantile(values, 0.5));  // of a normal distribution
  const std::vector<Peak> peaks = brightest_peaks(image, expected, look.dark, look.full);
  if (peaks.empty()) return look;
  const auto rank = std::size_t((1.0 - kPercentile) * expected.count);
  look.brightest = peaks[std::min(rank, peaks.size() - 1)].dn;
  look.lit = look.brightest - double(median) > std::max(1.0, kSignificance * noise);
  if (look.brightest >= look.full) look.brightest = NAN;
  return look;
}

}  // namespace ovws
