#include "core/tracking/spot_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

#include "core/tracking/spot_shape.hpp"

namespace ovws {
namespace {

// Radii of discs and annuli relative to the radii in SpotGeometry, and acceptance limits. Tests in
// tests/unit/tracking check the limits against genuine cores and against false zeros.
constexpr double kCoreOfRingInner = 0.45;  // radius of a vortex core's disc
constexpr double kCoreOfHalfWidth = 0.6;   // radius of a bright spot's disc
constexpr double kFlank = 1.2;             // outer radius of a bright spot's flank
constexpr double kOuterFrom = 0.92, kOuterTo = 1.08;
constexpr double kMaxCoreOfRing = 0.45;     // core / mean ring
constexpr double kMinWeakestOfRing = 0.15;  // (weakest sector - core) / (mean ring - core)
constexpr double kMaxOutsideOfRing = 1.5;   // brightest outer sector / mean ring
constexpr double kMinFlankOfCore = 0.25;    // mean flank / bright core; a hot pixel has no flank
constexpr double kMaxSurroundOfCore = 0.5;  // brightest sector of the dark ring / bright core
constexpr double kSignificance = 7.0;       // standard errors of (bright part - dark part)
constexpr double kUnsure = 3.5;  // level / pixel noise below which small areas are inconclusive
// Fit of the ideal spot: radius of the disc, significance of the amplitude, and largest energy of
// the residual over the energy of the fit. For 0.2 wave RMS of any mode up to j = 14 this ratio is
// up to 1.5 (vortex) or 0.4 (bright spot). It is 3.8 or more for stripes and spots of another
// charge, and 0.7 for half a bright spot.
constexpr double kDiscOfDark = 0.98;
constexpr double kMinAmplitude = 8.0;  // standard errors
constexpr double kMaxLeftOfVortex = 1.5, kMaxLeftOfBright = 0.6;
constexpr double kMinSectorOfRing = 0.2;    // intensity of a sector / of the fitted ring
constexpr double kNoiseErrors = 3.0;        // standard errors that are attributed to noise
constexpr double kQuantisation = 1.0 / 12;  // variance of rounding to whole DN
constexpr int kNoiseRowStep = 6;            // every 6th row suffices to estimate the noise

int outer_limit_px(const SpotModel& spots, const SpotGeometry& geometry) {
  return int(std::ceil(kOuterTo * geometry.dark * spots.lambda_d_px)) + 1;
}

/// RMS pixel noise from fourth differences along rows. The filter 1 -4 6 -4 1 has the norm sqrt(70)
/// and suppresses a diffraction-limited spot.
double noise_of(const Patch& patch) {
  const int rows = (patch.side + kNoiseRowStep - 1) / kNoiseRowStep;
  const float sum = fourth_differences(
      {patch.pixels, std::ptrdiff_t(kNoiseRowStep) * patch.side, patch.side, rows});
  return std::sqrt(double(sum) / (70.0 * rows * (patch.side - 4)) + kQuantisation);
}

/// Sum of the pixels at `offsets`, in four accumulators so that the CPU can overlap the additions.
/// Exact for up to 1024 pixels of 16 bits; of more the last bits are rounded.
double sum_at(const float* centre, std::span<const int> offsets) {
  float a = 0.0F, b = 0.0F, c = 0.0F, d = 0.0F;
  std::size_t k = 0;
  for (; k + 3 < offsets.size(); k += 4) {
    a += centre[offsets[k]];
    b += centre[offsets[k + 1]];
    c += centre[offsets[k + 2]];
    d += centre[offsets[k + 3]];
  }
  for (; k < offsets.size(); ++k) a += centre[offsets[k]];
  return double(a) + double(b) + double(c) + double(d);
}

const float* centre_of(const Patch& patch, Vec2 at) {
  return patch.at(int(std::lround(at.x)), int(std::lround(at.y)));
}

double mean_of(const auto& means) {
  return std::accumulate(means.begin(), means.end(), 0.0) / double(means.size());
}

std::vector<int> disc(double radius_px, int side) {
  std::vector<int> offsets;
  const int reach = int(std::floor(radius_px));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      if (dx * dx + dy * dy <= radius_px * radius_px) offsets.push_back(dy * side + dx);
    }
  }
  return offsets;
}

}  // namespace

SpotCheck::Annulus SpotCheck::annulus(double inner_px, double outer_px, int side) {
  std::array<std::vector<int>, kSectors> sectors;
  const int reach = int(std::ceil(outer_px));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double r = std::hypot(dx, dy);
      if (r < inner_px || r > outer_px) continue;
      const double turn = std::atan2(dy, dx) / (2.0 * std::numbers::pi) + 1.0;
      sectors[std::size_t(std::lround(turn * kSectors)) % kSectors].push_back(dy * side + dx);
    }
  }
  Annulus a;
  for (int k = 0; k < kSectors; ++k) {
    a.offsets.insert(a.offsets.end(), sectors[k].begin(), sectors[k].end());
    a.begin[k + 1] = int(a.offsets.size());
  }
  return a;
}

SpotCheck::Means SpotCheck::Annulus::means(const float* centre) const {
  Means means{};
  double last = double(*centre);
  for (int k = 0; k < kSectors; ++k) {
    const double sum =
        sum_at(centre, std::span(offsets).subspan(begin[k], begin[k + 1] - begin[k]));
    // A sector without pixels (very small spots) repeats the previous sector's mean.
    last = begin[k + 1] > begin[k] ? sum / (begin[k + 1] - begin[k]) : last;
    means[k] = last;
  }
  return means;
}

int SpotCheck::reach_px(const SpotModel& spots, const SpotGeometry& geometry) {
  return outer_limit_px(spots, geometry);
}

double SpotCheck::spot_half_px(const SpotModel& spots, const SpotGeometry& geometry) {
  return geometry.ring_outer * spots.lambda_d_px;
}

SpotCheck::SpotCheck(const SpotModel& spots, const SpotGeometry& geometry, int patch_half)
    : charge_(spots.charge) {
  const double px = spots.lambda_d_px;
  const int side = 2 * patch_half + 1;
  const double core = charge_ != 0 ? kCoreOfRingInner * geometry.ring_inner
                                   : kCoreOfHalfWidth * geometry.ring_outer;
  core_ = disc(std::max(1.0, core * px), side);
  // The outer annulus is at least two pixels wide, so that no sector is empty.
  const double from = kOuterFrom * geometry.dark * px;
  outer_ = annulus(from, std::max(from + 2.0, kOuterTo * geometry.dark * px), side);
  around_ = charge_ != 0 ? annulus(geometry.ring_inner * px, geometry.ring_outer * px, side)
                         : annulus(core * px, kFlank * geometry.ring_outer * px, side);
  disc_ = disc(kDiscOfDark * geometry.dark * px, side);
  const ModelShape shape(spots, geometry.dark);
  int bright = 0;
  for (const int offset : disc_) {
    const int y = (offset + patch_half * (side + 1)) / side - patch_half;
    const double value = shape.at({double(offset - y * side), double(y)}).value;
    ideal_.push_back(float(value));
    ideal_mean_ += value / double(disc_.size());
    if (value > 0.5) ideal_bright_ += value, ++bright;
  }
  ideal_bright_ /= std::max(bright, 1);
  for (float& value : ideal_) {
    value -= float(ideal_mean_);
    ideal_squares_ += double(value * value);
  }
}

double SpotCheck::background(const Patch& patch, Vec2 at) const {
  return outside(centre_of(patch, at)).background;
}

SpotCheck::Outside SpotCheck::outside(const float* centre) const {
  Means means = outer_.means(centre);
  const auto half = means.begin() + kSectors / 2;
  std::nth_element(means.begin(), half, means.end());
  return {mean_of(means), std::accumulate(means.begin(), half, 0.0) / (0.5 * kSectors),
          *std::max_element(half, means.end())};
}

SpotCheck::Verdict SpotCheck::look(const Patch& patch, Vec2 at) const {
  const float* centre = centre_of(patch, at);
  const double core = sum_at(centre, core_) / double(core_.size());
  const Means around = around_.means(centre);
  const Outside out = outside(centre);
  const double noise = noise_of(patch);
  const Verdict verdict =
      charge_ != 0 ? vortex(core, around, out, noise) : bright(core, around, out, noise);
  const bool unsure = verdict.level > 0.0 && verdict.level < kUnsure * noise;
  return verdict.passed || !unsure ? verdict : whole(centre, core, around, noise);
}

double SpotCheck::significance(std::size_t around) const {
  return kSignificance * std::sqrt(1.0 / double(core_.size()) + 1.0 / double(around));
}

SpotCheck::Verdict SpotCheck::vortex(double core, const Means& ring, const Outside& out,
                                     double noise) const {
  const double mean = mean_of(ring);
  const double weakest = *std::min_element(ring.begin(), ring.end());
  const double above = mean - core;
  const double level = mean - out.background;
  const bool stands_out = above > noise * significance(around_.offsets.size());
  const bool closed = weakest - core > kMinWeakestOfRing * above;
  const bool dark = core - out.background < kMaxCoreOfRing * level;
  const bool alone = out.brightest - out.background < kMaxOutsideOfRing * level;
  if (!stands_out || !closed || !dark || !alone || level <= 0.0) return {false, 0.0, level, noise};
  return {true, std::clamp(1.0 - (core - out.background) / level, 0.0, 1.0), level, noise};
}

SpotCheck::Verdict SpotCheck::bright(double core, const Means& flank, const Outside& out,
                                     double noise) const {
  const double level = core - out.background;
  const bool stands_out = core - out.mean > noise * significance(outer_.offsets.size());
  const bool broad = mean_of(flank) - out.background > kMinFlankOfCore * level;
  const bool alone = out.brightest - out.background < kMaxSurroundOfCore * level;
  if (!stands_out || !broad || !alone) return {false, 0.0, level, noise};
  return {true, std::clamp(1.0 - (out.brightest - out.background) / level, 0.0, 1.0), level, noise};
}

/// Fit of the ideal spot: passes if noise and aberration can explain the residual. A vortex must
/// also have a ring in every direction and a dark core.
SpotCheck::Verdict SpotCheck::whole(const float* centre, double core, const Means& ring,
                                    double noise) const {
  const auto pixels = double(disc_.size());
  double sum = 0.0, squares = 0.0, product = 0.0;
  for (std::size_t k = 0; k < disc_.size(); ++k) {
    const double value = double(centre[disc_[k]] - *centre);
    sum += value;
    squares += value * value;
    product += value * double(ideal_[k]);
  }
  const double amplitude = product / ideal_squares_;
  const double background = sum / pixels - amplitude * ideal_mean_ + double(*centre);
  const double light = amplitude * product;
  const double left = squares - sum * sum / pixels - light;
  const double least = std::max(noise * noise, left / pixels);
  const double beyond = std::max(left - pixels * noise * noise, 0.0);
  Verdict verdict{false, light / (light + beyond), amplitude * ideal_bright_, noise};
  const double limit = charge_ != 0 ? kMaxLeftOfVortex : kMaxLeftOfBright;
  const bool stands_out = amplitude > 0.0 && light > kMinAmplitude * kMinAmplitude * least;
  const bool alike =
      beyond <= limit * light + kNoiseErrors * std::sqrt(2.0 * pixels) * noise * noise;
  if (!stands_out || !alike) return {false, 0.0, verdict.level, noise};
  verdict.passed = true;
  if (charge_ == 0) return verdict;
  const double sector_error = noise * std::sqrt(kSectors / (2.0 * double(around_.offsets.size())));
  for (int k = 0; k < kSectors; k += 2) {
    const double intensity_there = 0.5 * (ring[k] + ring[k + 1]) - background;
    verdict.passed = verdict.passed && intensity_there > kMinSectorOfRing * verdict.level -
                                                             kNoiseErrors * sector_error;
  }
  const double core_error = noise / std::sqrt(double(core_.size()));
  verdict.passed =
      verdict.passed && core - background < kMaxCoreOfRing * amplitude + kNoiseErrors * core_error;
  return verdict;
}

}  // namespace ovws
