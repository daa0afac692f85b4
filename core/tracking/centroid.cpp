#include "core/tracking/centroid.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

constexpr double kRegion = 2.0;           // centroid's disc, units of lambda/d
constexpr double kThresholdRegion = 1.2;  // thresholded's disc, units of lambda/d
constexpr double kThreshold = 0.2;        // share of the local peak above the local background
constexpr double kMinLightShare = 0.25;
constexpr int kMaxMoves = 60;
constexpr double kConvergedPx =
    5e-4;  // a mean-shift step below this ends the iteration; each step halves the error
constexpr double kDiscConvergedPx =
    0.02;  // a disc step below this ends the iteration: hardly a pixel enters or leaves the disc

struct Sums {
  double light = 0.0;
  Vec2 centroid;
};

/// Centroid of max(I - threshold, 0) over the disc around `centre`.
Sums disc_centroid(const Patch& patch, Vec2 centre, double radius, double threshold) {
  double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
  const int top = int(std::ceil(centre.y - radius)), bottom = int(std::floor(centre.y + radius));
  for (int y = top; y <= bottom; ++y) {
    const double half = std::sqrt(std::max(0.0, radius * radius - (y - centre.y) * (y - centre.y)));
    const int left = int(std::ceil(centre.x - half)), right = int(std::floor(centre.x + half));
    const float* row = patch.at(0, y);
    double row_sum = 0.0;
    for (int x = left; x <= right; ++x) {
      const double above = std::max(0.0, double(row[x]) - threshold);
      row_sum += above;
      sum_x += above * (x - centre.x);
    }
    sum += row_sum;
    sum_y += row_sum * (y - centre.y);
  }
  if (!(sum > 0.0)) return {};
  return {sum, centre + Vec2{sum_x / sum, sum_y / sum}};
}

/// Mean-shift iteration: moves the Gaussian window to the centroid of the intensity in it until it
/// converges. None if it does not converge within `reach` pixels of `start`.
std::optional<Vec2> mean_shift(const Patch& patch, const GaussianWindow& window, Vec2 start,
                               double reach, double background, std::span<float> sums) {
  Vec2 at = start;
  GaussianWindow::Centre centre(start);
  for (int k = 0; k < kMaxMoves; ++k) {
    centre.follow(at);
    const Moments m = window.at(patch, at, centre, sums);
    // The background estimate changes the step length, not the fixed point. It may be too high if
    // the start is beside the spot, so a share of the total intensity is the lower limit.
    const double all = m.one - double(patch.darkest) * m.weight;
    const double light = std::max(m.one - background * m.weight, kMinLightShare * all);
    if (!(light > 0.0)) return std::nullopt;
    const Vec2 move{m.x / light, m.y / light};
    at = at + move;
    if (norm(at - start) > reach) return std::nullopt;
    if (norm(move) < kConvergedPx) return at;
  }
  return std::nullopt;
}

GaussianWindow window_of(const SpotModel& spots) {
  return GaussianWindow(WeightedTracker::kWindowRadius * spots.lambda_d_px);
}

}  // namespace

CentroidTracker::CentroidTracker(const SpotModel& spots)
    : PatchTracker(spots, window_of(spots).half_px(), window_of(spots).scratch_floats()),
      locator_(window_of(spots)) {}

std::optional<PatchTracker::Found> CentroidTracker::find(Patch& patch, Vec2 start,
                                                         TrackScratch& scratch) const {
  const auto spot = mean_shift(patch, locator_, start, capture_px(),
                               check().background(patch, start), scratch.sums);
  if (!spot) return std::nullopt;
  const SpotCheck::Verdict verdict = check().look(patch, *spot);
  if (!verdict.passed) return std::nullopt;
  const Sums sums = disc_centroid(patch, start, kRegion * spots().lambda_d_px, 0.0);
  return Found{sums.centroid, verdict};
}

ThresholdedTracker::ThresholdedTracker(const SpotModel& spots)
    : PatchTracker(spots, int(std::ceil(kThresholdRegion * spots.lambda_d_px)), 0) {}

std::optional<PatchTracker::Found> ThresholdedTracker::find(Patch& patch, Vec2 start,
                                                            TrackScratch&) const {
  const double radius = kThresholdRegion * spots().lambda_d_px;
  Vec2 at = start;
  for (int k = 0; k < kMaxMoves; ++k) {
    const double floor = check().background(patch, at);
    const double peak = double(patch.brightest(at, int(std::floor(radius))));
    const Sums sums = disc_centroid(patch, at, radius, floor + kThreshold * (peak - floor));
    if (!(sums.light > 0.0) || norm(sums.centroid - start) > capture_px()) return std::nullopt;
    const double move = norm(sums.centroid - at);
    at = sums.centroid;
    if (move > kDiscConvergedPx) continue;
    const SpotCheck::Verdict verdict = check().look(patch, at);
    if (!verdict.passed) return std::nullopt;
    return Found{at, verdict};
  }
  return std::nullopt;
}

WeightedTracker::WeightedTracker(const SpotModel& spots)
    : PatchTracker(spots, window_of(spots).half_px(), window_of(spots).scratch_floats()),
      window_(window_of(spots)) {}

std::optional<PatchTracker::Found> WeightedTracker::find(Patch& patch, Vec2 start,
                                                         TrackScratch& scratch) const {
  const auto spot = mean_shift(patch, window_, start, capture_px(),
                               check().background(patch, start), scratch.sums);
  if (!spot) return std::nullopt;
  const SpotCheck::Verdict verdict = check().look(patch, *spot);
  if (!verdict.passed) return std::nullopt;
  return Found{*spot, verdict};
}

}  // namespace ovws
