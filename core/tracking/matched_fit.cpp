#include "core/tracking/matched_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/tracking/patch.hpp"

namespace ovws {
namespace {

constexpr double kMaxMove = 0.15;  // lambda/d, of one Gauss-Newton step
constexpr int kMaxMoves = 10;
constexpr double kKeepShift = 0.65;  // of a shift: smaller moves keep the tabulated shift
constexpr double kMaxOffset = 2.0;   // of a shift: limit for a converged fit
constexpr double kMinGain = 0.25;
constexpr double kMaxAnisotropy = 0.12;  // of the gain: above, a second direction is evaluated
constexpr double kMinMixWeight = 0.02;   // smallest weight of the next level that is worth a fit
constexpr double kMinSignificance = 8.0;
// Largest residual contrast relative to what the template explains. Aberration inside the
// subaperture spoils a vortex sooner than a bright spot: 0.2 wave RMS of any mode up to j = 14
// leaves 0.4 (bright spot) and 1.5 (vortex). Stripes and spots of another charge leave 3.8 and
// more, half a bright spot 0.7.
constexpr double kMaxMisfitOfBright = 0.6, kMaxMisfitOfVortex = 1.5;
constexpr double kMinSector = 0.2;          // a sector's intensity / the template's
constexpr double kMaxCore = 0.45;           // a vortex core's intensity / the amplitude
constexpr double kQuantisation = 1.0 / 12;  // variance of rounding to whole DN, the lower limit
constexpr double kNoiseErrors = 3.0;        // standard errors that are attributed to noise

double dot(Vec2 a, Vec2 b) {
  return a.x * b.x + a.y * b.y;
}

/// The full Gauss-Newton step, px.
Vec2 full_move(const TemplateFit& fit) {
  return {double(fit.move_x) / double(fit.amplitude), double(fit.move_y) / double(fit.amplitude)};
}

/// Damped Gauss-Newton gain, from a secant estimate over two steps. Where the spot differs much
/// from the template, full steps overshoot the minimum and would oscillate.
double damped(double gain, Vec2 step, Vec2 change) {
  const double along = -dot(change, step);
  return along > 0.0 ? std::clamp(dot(step, step) / along, kMinGain, 1.0) : gain;
}

}  // namespace

MatchedFit::MatchedFit(const TemplateBank& bank, const TemplateKernels& kernels,
                       const ImageView& image, const SpotModel& spots, TrackScratch& scratch)
    : bank_(bank),
      kernels_(kernels),
      image_(image),
      scratch_(scratch),
      max_move_px_(kMaxMove * spots.lambda_d_px),
      max_misfit_(spots.charge == 0 ? kMaxMisfitOfBright : kMaxMisfitOfVortex) {}

bool MatchedFit::follow(Vec2 from, Vec2 start, double reach_px) {
  Vec2 at = from;
  double gain = 1.0;
  Vec2 previous, previous_move;
  for (int k = 0; k < kMaxMoves; ++k) {
    if (!solve(bank_.place(at))) return false;
    const Vec2 full = full_move(fit_);
    if (k > 0 && dot(full, previous_move) < 0.0) {
      gain = damped(gain, place_.centre - previous, full - previous_move);
    }
    previous = place_.centre;
    previous_move = full;
    move_ = gain * full;
    if (std::max(std::abs(move_.x), std::abs(move_.y)) <= kKeepShift * bank_.step_px())
      return settle();
    const double length = norm(move_), limit = max_move_px_;
    at = place_.centre + (length > limit ? limit / length : 1.0) * move_;
    if (!(norm(at - start) <= reach_px)) return false;
  }
  return false;
}

double MatchedFit::score(Vec2 at) {
  if (!solve(bank_.place(at))) return 0.0;
  return double(fit_.amplitude) * double(fit_.amplitude);
}

bool MatchedFit::is_spot() {
  const TemplateBank::Solver& solver = bank_.solver(place_, kMiddleNoise);
  const double pixels = bank_.pixels(), a = amplitude();
  const double floor = kQuantisation * solver.weight / pixels;
  const double spread = std::max(double(sums_.square) / pixels, floor);
  const double noise = std::max(double(sums_.difference) / pixels, floor);
  if (a * a < kMinSignificance * kMinSignificance * spread * double(solver.inverse[5]))
    return false;
  noise_ = std::sqrt(noise * pixels / double(solver.weight));
  const double light = a * a * solver.contrast;
  const double misfit = std::max(double(sums_.square) - noise * pixels, 0.0);
  quality_ = light / (light + misfit);
  return misfit <= max_misfit_ * light + kNoiseErrors * std::sqrt(2.0 * pixels) * noise &&
         is_complete(noise);
}

Vec2 MatchedFit::found() const {
  return place_.centre + move_;
}

void MatchedFit::load(const TemplateBank::Place& place) {
  if (loaded_ && place.x == window_x_ && place.y == window_y_) return;
  load_window(image_, place.x - bank_.columns() / 2, place.y - bank_.rows() / 2, bank_.columns(),
              bank_.rows(), scratch_.samples.data());
  window_x_ = place.x;
  window_y_ = place.y;
  loaded_ = true;
}

/// Linear fit at a tabulated shift and a noise level.
TemplateFit MatchedFit::fit_at(const TemplateBank::Place& place, int level) {
  load(place);
  const TemplateMoments m = kernels_.moments(bank_.view(place, level), scratch_.samples.data());
  const auto& c = bank_.solver(place, level).inverse;
  const auto row = [&](std::size_t i) {
    return c[i] * m.one + c[i + 1] * m.value + c[i + 2] * m.cx + c[i + 3] * m.cy;
  };
  return {row(0), row(4), row(8), row(12)};
}

/// Fits at `place`, which becomes the current one. True if the amplitude is positive.
bool MatchedFit::solve(const TemplateBank::Place& place) {
  fit_ = fit_at(place, kMiddleNoise);
  place_ = place;
  return fit_.amplitude > 0.0F;
}

/// Final fit at the nearest shift, so that the result hardly depends on the start.
bool MatchedFit::settle() {
  const TemplateBank::Place nearest = bank_.place(found());
  if (!(nearest == place_) && !solve(nearest)) return false;
  const NoiseMix noise = estimate_noise();
  interpolate(noise);
  return fit_.amplitude > 0.0F && broyden_step(noise);
}

/// Estimates the noise of the converged fit as a mix of two levels. A sudden change of the weights
/// would make the position jump.
MatchedFit::NoiseMix MatchedFit::estimate_noise() {
  sums_ = kernels_.residuals(bank_.view(place_, kMiddleNoise), scratch_.samples.data(), fit_,
                             scratch_.sums.data());
  const TemplateBank::Solver& s = bank_.solver(place_, kMiddleNoise);
  // Model of the variance: dark + bright T, by least squares with the weights w^2; both sums are of
  // w^2 e^2 / 2.
  const double det = s.ww * s.wwtt - s.wwt * s.wwt;
  const double dark =
      std::max(s.wwtt * double(sums_.dark) - s.wwt * double(sums_.bright), kQuantisation * det);
  const double bright = s.ww * double(sums_.bright) - s.wwt * double(sums_.dark);
  const double middle = kNoiseLevels[kMiddleNoise];
  const bool dark_dominates = dark > middle * bright;  // by chance `bright` may be 0 or negative
  const int next = dark_dominates ? kMiddleNoise + 1 : kMiddleNoise - 1;
  const double log_range = std::log(kNoiseLevels[std::size_t(next)] / middle);
  const double weight =
      bright > 0.0 ? std::min(std::log(dark / (middle * bright)) / log_range, 1.0) : 1.0;
  return {next, weight < kMinMixWeight ? 0.0F : float(weight)};
}

/// Interpolates the fit between the middle noise level and the next.
void MatchedFit::interpolate(NoiseMix noise) {
  middle_ = fit_;
  if (noise.weight == 0.0F) return;
  next_ = fit_at(place_, noise.next);
  const auto between = [&](float from, float to) { return from + noise.weight * (to - from); };
  fit_ = {between(middle_.background, next_.background),
          between(middle_.amplitude, next_.amplitude), between(middle_.move_x, next_.move_x),
          between(middle_.move_y, next_.move_y)};
}

/// Broyden step to the position where the full move vanishes, from its values at the converged
/// shift and at a neighbouring one. If the spot differs in shape from the template, the full move
/// changes by more or less than the shift. To first order only local astigmatism has this effect:
/// the gain rises along one axis as much as it falls along the perpendicular one. If that
/// anisotropy is large, a shift in the perpendicular direction is evaluated, too.
bool MatchedFit::broyden_step(NoiseMix noise) {
  const bool mostly_next = noise.weight > 0.5F;
  const int level = mostly_next ? noise.next : kMiddleNoise;
  const Vec2 full = full_move(fit_), at_level = full_move(mostly_next ? next_ : middle_);
  const auto change_to = [&](const TemplateBank::Place& there) {
    return at_level - full_move(fit_at(there, level));
  };
  const TemplateBank::Place there = neighbour(full);
  const Vec2 step = there.centre - place_.centre, change = change_to(there);
  const double square = dot(step, step);
  const Vec2 more = (1.0 / square) * (change - step);
  const double even = more.x * step.x - more.y * step.y;
  const double odd = more.x * step.y + more.y * step.x;
  Vec2 by_x{1.0 + even, odd}, by_y{odd, 1.0 - even};  // Jacobian of the full move, per px
  if (std::hypot(even, odd) > kMaxAnisotropy) {
    const TemplateBank::Place third = neighbour({-step.y, step.x});
    const Vec2 across = third.centre - place_.centre, change_across = change_to(third);
    const double det = step.x * across.y - step.y * across.x;
    by_x = (1.0 / det) * (across.y * change - step.y * change_across);
    by_y = (1.0 / det) * (step.x * change_across - across.x * change);
  }
  load(place_);
  const double det = by_x.x * by_y.y - by_x.y * by_y.x;
  move_ = full;
  if (det > kMinGain) {
    move_ =
        (1.0 / det) * Vec2{by_y.y * full.x - by_y.x * full.y, by_x.x * full.y - by_x.y * full.x};
  }
  return std::max(std::abs(move_.x), std::abs(move_.y)) <= kMaxOffset * bank_.step_px();
}

/// A neighbouring shift, as nearly as possible along `direction` or against it; with the same pixel
/// window, if there is one.
TemplateBank::Place MatchedFit::neighbour(Vec2 direction) const {
  const double step = bank_.step_px(), x = std::abs(direction.x), y = std::abs(direction.y);
  constexpr double kFlat = 0.414;  // tan 22.5 degrees
  const Vec2 along{x < kFlat * y ? 0.0 : std::copysign(step, direction.x),
                   y < kFlat * x ? 0.0 : std::copysign(step, direction.y)};
  const Vec2 steeper = x < y ? Vec2{0.0, along.y} : Vec2{along.x, 0.0};
  for (const Vec2 off : {along, -1.0 * along, steeper, -1.0 * steeper}) {
    const TemplateBank::Place place = bank_.place(place_.centre + off);
    if (place.x == place_.x && place.y == place_.y) return place;
  }
  return bank_.place(place_.centre + steeper);
}

int MatchedFit::count_of(int part) const {
  return bank_.parts().begin[part + 1] - bank_.parts().begin[part];
}

double MatchedFit::mean_of(int part) const {
  const TemplateBank::Parts& parts = bank_.parts();
  float even = 0.0F, odd = 0.0F;  // two accumulators, so that additions are independent
  int k = parts.begin[part];
  for (; k + 1 < parts.begin[part + 1]; k += 2) {
    even += scratch_.samples[parts.offsets[k]];
    odd += scratch_.samples[parts.offsets[k + 1]];
  }
  if (k < parts.begin[part + 1]) even += scratch_.samples[parts.offsets[k]];
  return double(even + odd) / std::max(1, count_of(part)) - double(fit_.background);
}

/// Whether every sector is bright and a vortex's core is dark. `noise`: variance times weight.
bool MatchedFit::is_complete(double noise) const {
  const double level = kNoiseLevels[kMiddleNoise], a = amplitude();
  for (int i = 0; i < TemplateBank::Parts::kSectors; ++i) {
    const double value = double(bank_.parts().value[i]);
    const double error = std::sqrt(noise * (level + value) / std::max(1, count_of(i)));
    if (mean_of(i) < kMinSector * a * value - kNoiseErrors * error) return false;
  }
  constexpr int kCore = TemplateBank::Parts::kSectors;
  if (count_of(kCore) == 0) return true;
  const double error = std::sqrt(noise * level / count_of(kCore));
  return mean_of(kCore) < kMaxCore * a + kNoiseErrors * error;
}

}  // namespace ovws
