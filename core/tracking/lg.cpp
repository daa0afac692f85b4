#include "core/tracking/lg.hpp"

#include <algorithm>
#include <cmath>

namespace ovws {
namespace {

constexpr int kMaxSteps = 20;
constexpr double kSpare = 0.25;  // spots are rarely farther from the start, units of lambda/d
// Step that ends the iteration. The error is then 1e-5, and more where the curvature is small.
constexpr double kConvergedStepPx = 2e-3;
constexpr double kMaxStep = 0.5;  // longest step, units of w
// Limit of the smaller curvature relative to the spot's level, which is 0.25 without aberration.
// Below the limit the zero is about to merge with a saddle. It is then pixels away from the
// position that the phase slope gives.
constexpr double kMinSharpness = 0.03;
constexpr double kMinCurvature = 0.1;  // of the smoothed intensity: limits steps in flat regions

/// Half the difference of the Hessian's eigenvalues; the mean of the eigenvalues is half the trace.
double half_gap_of(const Moments::Hessian& h) {
  const double difference = 0.5 * (h.xx - h.yy);
  return std::sqrt(difference * difference + h.xy * h.xy);
}

double min_curvature(const Moments::Hessian& h) {
  const double gap = half_gap_of(h);
  return std::min(std::abs(0.5 * h.trace() + gap), std::abs(0.5 * h.trace() - gap));
}

/// Saddle-free Newton step towards a minimum (sign = 1) or a maximum (sign = -1): the Hessian's
/// eigenvalues are replaced by their magnitudes, so that a saddle repels. A function f of a
/// symmetric 2 x 2 matrix H is (f1 + f2)/2 + (f1 - f2)/2 N, where f1 and f2 are its values at the
/// eigenvalues and N is the traceless part of H over half_gap. No eigenvectors are needed.
Vec2 step_of(const Moments& m, const Moments::Hessian& h, double light, double sign) {
  const double mean = 0.5 * h.trace();
  const double half_gap = half_gap_of(h);
  const double floor = kMinCurvature * light;
  const double f1 = 1.0 / std::max(std::abs(mean + half_gap), floor);
  const double f2 = 1.0 / std::max(std::abs(mean - half_gap), floor);
  const double isotropic = 0.5 * (f1 + f2);
  const double anisotropic = half_gap > 0.0 ? 0.5 * (f1 - f2) / half_gap : 0.0;
  const double difference = 0.5 * (h.xx - h.yy);
  return {-sign * ((isotropic + anisotropic * difference) * m.x + anisotropic * h.xy * m.y),
          -sign * (anisotropic * h.xy * m.x + (isotropic - anisotropic * difference) * m.y)};
}

}  // namespace

LgTracker::LgTracker(const SpotModel& spots, double kernel_radius_px)
    : PatchTracker(spots, GaussianWindow(kernel_radius_px).half_px(),
                   GaussianWindow(kernel_radius_px).scratch_floats(), kSpare),
      window_(kernel_radius_px) {}

std::optional<PatchTracker::Found> LgTracker::find(Patch& patch, Vec2 start,
                                                   TrackScratch& scratch) const {
  const double w = window_.radius_px();
  const double sign = spots().charge != 0 ? 1.0 : -1.0;
  Vec2 at = start;
  GaussianWindow::Centre centre(start);
  for (int k = 0; k < kMaxSteps; ++k) {
    if (!patch.follow(at, spare_px(), scratch.samples)) return std::nullopt;
    centre.follow(at);
    const Moments m = window_.at(patch, at, centre, scratch.sums);
    const double light = m.one - double(patch.darkest) * m.weight;
    if (!(light > 0.0)) return std::nullopt;
    const Moments::Hessian h = m.hessian(w);
    Vec2 step = step_of(m, h, light, sign);
    const double length = norm(step);
    if (length > kMaxStep * w) step = (kMaxStep * w / length) * step;
    at = at + step;
    if (norm(at - start) > capture_px()) return std::nullopt;
    if (length > kConvergedStepPx) continue;
    if (h.det() <= 0.0 || sign * h.trace() <= 0.0) return std::nullopt;
    if (!patch.follow(at, spare_px(), scratch.samples)) return std::nullopt;
    const SpotCheck::Verdict verdict = check().look(patch, at);
    const double sharpness = min_curvature(h) / (m.weight * verdict.level);
    if (!verdict.passed || sharpness < kMinSharpness) return std::nullopt;
    return Found{at, verdict};
  }
  return std::nullopt;
}

}  // namespace ovws
