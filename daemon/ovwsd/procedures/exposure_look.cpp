#include "daemon/ovwsd/procedures/exposure_look.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "core/optics/lattice.hpp"

namespace ovws {
namespace {

constexpr double kSignificance = 6.0;  // of light, in standard deviations of the background
constexpr double kDarkShare = 0.05;    // fraction of the pixels that are darker than `dark`
constexpr double kHotContrast = 10.0;  // a hot pixel exceeds all its neighbours by this factor
constexpr double kResolvedPx = 1.5;    // narrower spots may look like hot pixels
// In spots as wide as this (lambda/d), light beside the top is at least 0.8 of it.
constexpr double kWidePx = 4.0, kBesideTop = 0.75;
constexpr std::array kShares{0.6, 0.4, 0.3};  // of the spots that must be about equally bright
constexpr int kMinEven = 6;                   // ... but more than the first side lobes
constexpr double kBeyondFull = 2.0;  // height that a saturated peak may have, per full scale
constexpr double kPercentile = 0.8;  // of these spots' brightest pixels
constexpr int kMorePeaks = 2;        // peaks that are looked at, relative to the spots
constexpr double kApart = 1.5;       // lambda/d between peaks of two spots, and ...
constexpr double kOfSpacing = 0.7;   // ... this share of the distance between two spots
constexpr double kOfDistance = 0.7;  // of `apart_px`, half that distance: the pixels of a spot

float or_full(float dn, double full) {
  return std::isnan(dn) ? float(full) : dn;
}

/// Height of the brightest neighbour of pixel `at` above the black level.
double beside(const Image<float>& image, std::size_t at, double dark, double full) {
  const int x = int(at % std::size_t(image.width)), y = int(at / std::size_t(image.width));
  double nearest = 0.0;
  for (int j = std::max(0, y - 1); j <= std::min(image.height - 1, y + 1); ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(image.width - 1, x + 1); ++i) {
      if (i != x || j != y)
        nearest = std::max(nearest, double(or_full(image.at(i, j), full)) - dark);
    }
  }
  return nearest;
}

/// Whether pixel `at` is much brighter than each of its neighbours.
bool is_hot(const Image<float>& image, std::size_t at, double dark, double full) {
  const double height = double(or_full(image.pixels[at], full)) - dark;
  return height > kHotContrast * std::max(beside(image, at, dark, full), 1e-9);
}

/// Whether pixel `at` of a wide spot is at full scale and its neighbours are not near it, as
/// beside the top of a spot: it is stuck, whatever the exposure.
bool is_stuck(const Image<float>& image, std::size_t at, double dark, double full) {
  return or_full(image.pixels[at], full) >= full &&
         beside(image, at, dark, full) < kBesideTop * (full - dark);
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

/// Heights of peaks above the black level, the highest first: more than there are spots, because a
/// zeroth order has side lobes that are brighter than spots.
std::vector<double> peak_heights(const Image<float>& image, const ExpectedSpots& expected,
                                 double dark, double full) {
  const double apart_px = std::max(1.0, expected.apart_px);
  auto all =
      tile_peaks(image, int(std::ceil(apart_px)), expected.size_px >= kResolvedPx, dark, full);
  std::sort(all.begin(), all.end(), [](const Peak& a, const Peak& b) { return a.dn > b.dn; });
  std::vector<Peak> found;
  for (const Peak& peak : all) {
    if (int(found.size()) == kMorePeaks * expected.count) break;
    const bool is_near = std::any_of(found.begin(), found.end(), [&](const Peak& other) {
      return std::hypot(peak.x - other.x, peak.y - other.y) < apart_px;
    });
    if (!is_near) found.push_back(peak);
  }
  std::vector<double> heights;
  for (const Peak& peak : found) heights.push_back(peak.dn - dark);
  return heights;
}

/// Heights of the found spots above the black level, the highest first; hot and stuck pixels do not
/// count.
std::vector<double> spot_heights(const Image<float>& image, const ExpectedSpots& expected,
                                 double dark, double full) {
  const double reach_px = std::max(1.0, kOfDistance * expected.apart_px);
  std::vector<double> heights;
  for (const Vec2 spot : expected.found_px) {
    double best = 0.0;
    for (int y = std::max(0, int(spot.y - reach_px));
         y <= std::min(image.height - 1, int(spot.y + reach_px)); ++y) {
      for (int x = std::max(0, int(spot.x - reach_px));
           x <= std::min(image.width - 1, int(spot.x + reach_px)); ++x) {
        const double height = double(or_full(image.at(x, y), full)) - dark;
        if (height <= best || norm(Vec2{double(x), double(y)} - spot) > reach_px) continue;
        const std::size_t at = std::size_t(y) * image.width + x;
        if (expected.size_px >= kResolvedPx && is_hot(image, at, dark, full)) continue;
        if (expected.size_px >= kWidePx && is_stuck(image, at, dark, full)) continue;
        best = height;
      }
    }
    heights.push_back(best);
  }
  std::ranges::sort(heights, std::ranges::greater());
  return heights;
}

/// Rank of the peak at kPercentile among `count`, the highest first.
std::size_t rank_of(int count) {
  return std::size_t((1.0 - kPercentile) * count);
}

double smallest_spacing_cpp(const Lattice& lattice) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < lattice.subapertures.size(); ++k) {
    for (std::size_t i = 0; i < k; ++i) {
      least = std::min(least, norm(lattice.subapertures[k].frequency_cpp -
                                   lattice.subapertures[i].frequency_cpp));
    }
  }
  return std::isfinite(least) ? least : 0.0;
}

/// The height of the spots among lit peaks; `full` is that of a saturated peak. Spots are many and
/// about equally bright, side lobes of a zeroth order are not: of all runs of successive peaks,
/// that which is the most even, the brightest and the longest. None: too few peaks.
std::optional<double> height_of_spots(const std::vector<double>& heights, int count, double full) {
  if (count == 1) return heights.front();
  double best = 0.0;
  std::optional<double> height;
  for (const double share : kShares) {
    const int length = std::min(count, std::max(int(std::ceil(share * count)), kMinEven));
    for (std::size_t first = 0; first + std::size_t(length) <= heights.size(); ++first) {
      const double top = heights[first] < full ? heights[first] : kBeyondFull * full;
      const double last = heights[first + std::size_t(length) - 1], evenness = last / top;
      const double score = last * evenness * evenness * share;
      if (score <= best) continue;
      best = score;
      height = heights[first + rank_of(length)];
    }
  }
  return height;
}

}  // namespace

Result<ExpectedSpots> expected_spots(const SensorSnapshot& now, const SlmGeometry& slm,
                                     const LitPixels& lit) {
  const double spot_px = lambda_d_px(now.optics, slm, now.sensor) / lit.plane.step;
  if (now.pattern != HologramKind::sensor) {
    const double whole_pupil_px = spot_px / now.sensor.subapertures_across;
    return ExpectedSpots{1, whole_pupil_px, kApart * whole_pupil_px};
  }
  const auto lattice = make_lattice(now.sensor, slm);
  if (!lattice) return fail(lattice.error());
  const double px_per_cpp = camera_px_per_cycle(now.optics, slm) / lit.plane.step;
  const double nearest_px = px_per_cpp * smallest_spacing_cpp(*lattice);
  return ExpectedSpots{now.subapertures, spot_px,
                       std::max(kApart * spot_px, kOfSpacing * nearest_px)};
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
  auto heights = peak_heights(image, expected, look.dark, look.full);
  if (heights.empty()) return look;
  look.brightest = look.dark + heights.front();
  const double least = double(median) - look.dark + std::max(1.0, kSignificance * noise);
  std::erase_if(heights, [&](double height) { return height <= least; });
  look.lit = !heights.empty();
  if (look.lit) {
    const auto of_spots = height_of_spots(heights, expected.count, look.full - look.dark);
    const std::size_t rank = std::min(rank_of(expected.count), heights.size() - 1);
    look.certain = of_spots.has_value();
    look.brightest = look.dark + of_spots.value_or(heights[rank]);
  }
  if (look.certain && 2 * int(expected.found_px.size()) >= expected.count) {
    const auto of_spots = spot_heights(image, expected, look.dark, look.full);
    look.brightest = look.dark + of_spots[rank_of(int(of_spots.size()))];
    look.top = look.dark + of_spots.front();
    if (*look.top >= look.full) look.top = NAN;
  }
  if (look.brightest >= look.full) look.brightest = NAN;
  return look;
}

}  // namespace ovws
