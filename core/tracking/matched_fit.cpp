#include "core/tracking/matched_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/tracking/patch.hpp"

namespace ovws {
namespace {

constexpr double kMaxMove = 0.15;  // lambda/d, of one Gauss-Newton step
constexpr int kMaxMoves = 10;
constexpr double kStay = 0.65;    // of a shift: the fit need not change to its neighbour
constexpr double kMaxRest = 2.0;  // of a shift: no fit is further from its template
constexpr double kLeastGain = 0.25;
constexpr double kLeastWay = 0.02;  // from one noise level to the next that is worth a fit
constexpr double kMinSignificance = 8.0;
// Contrast that the template may leave against what it explains. Aberration inside the subaperture
// spoils a vortex sooner than a bright spot: 0.2 wave RMS of any mode up to j = 14 leaves 0.4 and
// 1.5 of them, stripes and another charge's spots leave 3.8 and more, half a bright spot 0.7.
constexpr double kMaxMisfitOfBright = 0.6, kMaxMisfitOfVortex = 1.5;
constexpr double kMinSector = 0.2;          // a sector's light / the template's
constexpr double kMaxCore = 0.45;           // a vortex core's light / the amplitude
constexpr double kQuantisation = 1.0 / 12;  // variance of rounding to whole DN, the least there is
constexpr double kNoiseErrors = 3.0;        // standard errors that noise may explain

double dot(Vec2 a, Vec2 b) {
  return a.x * b.x + a.y * b.y;
}

}  // namespace

MatchedFit::MatchedFit(const TemplateBank& bank, const TemplateKernels& kernels,
                       const ImageView& image, const SpotModel& spots, TrackScratch& scratch)
    : bank_(bank),
      kernels_(kernels),
      image_(image),
      scratch_(scratch),
      longest_move_px_(kMaxMove * spots.lambda_d_px),
      max_misfit_(spots.charge == 0 ? kMaxMisfitOfBright : kMaxMisfitOfVortex) {}

bool MatchedFit::follow(Vec2 from, Vec2 start, double reach_px) {
  Vec2 at = from;
  level_ = kMiddleNoise;
  gain_ = 1.0;
  Vec2 before, moved_before;
  for (int k = 0; k < kMaxMoves; ++k) {
    if (!solve(bank_.place(at))) return false;
    const Vec2 full = full_move();
    if (k > 0 && dot(full, moved_before) < 0.0) damp(place_.centre - before, full - moved_before);
    before = place_.centre;
    moved_before = full;
    const Vec2 move = gain_ * full;
    if (std::max(std::abs(move.x), std::abs(move.y)) <= kStay * bank_.step_px()) return settle();
    const double length = norm(move), most = longest_move_px_;
    at = place_.centre + (length > most ? most / length : 1.0) * move;
    if (!(norm(at - start) <= reach_px)) return false;
  }
  return false;
}

double MatchedFit::score(Vec2 at) {
  level_ = kMiddleNoise;
  if (!solve(bank_.place(at))) return 0.0;
  return double(fit_.amplitude) * double(fit_.amplitude);
}

bool MatchedFit::is_spot() {
  const TemplateBank::Solver& solver = bank_.solver(place_, kMiddleNoise);
  const double pixels = bank_.pixels(), a = amplitude();
  const double least = kQuantisation * solver.weight / pixels;
  const double spread = std::max(double(sums_.square) / pixels, least);
  const double noise = std::max(double(sums_.difference) / pixels, least);
  if (a * a < kMinSignificance * kMinSignificance * spread * double(solver.inverse[5]))
    return false;
  noise_ = std::sqrt(noise * pixels / double(solver.weight));
  const double light = a * a * solver.contrast;
  const double misfit = std::max(double(sums_.square) - noise * pixels, 0.0);
  quality_ = light / (light + misfit);
  return misfit <= max_misfit_ * light + kNoiseErrors * std::sqrt(2.0 * pixels) * noise &&
         whole(noise);
}

Vec2 MatchedFit::found() const {
  return place_.centre + gain_ * full_move();
}

Vec2 MatchedFit::full_move() const {
  return {double(fit_.move_x) / double(fit_.amplitude),
          double(fit_.move_y) / double(fit_.amplitude)};
}

// Where the light differs much from the template, a Gauss-Newton step goes beyond the minimum, by
// how much two steps tell; else they would go on to and fro.
void MatchedFit::damp(Vec2 step, Vec2 change) {
  const double along = -dot(change, step);
  if (along > 0.0) gain_ = std::clamp(dot(step, step) / along, kLeastGain, 1.0);
}

/// Fits at a place; whether the template is bright there.
bool MatchedFit::solve(const TemplateBank::Place& place) {
  if (!loaded_ || place.x != place_.x || place.y != place_.y) {
    load_window(image_, place.x - bank_.columns() / 2, place.y - bank_.rows() / 2, bank_.columns(),
                bank_.rows(), scratch_.samples.data());
    loaded_ = true;
  }
  place_ = place;
  const TemplateMoments m = kernels_.moments(bank_.view(place, level_), scratch_.samples.data());
  const auto& c = bank_.solver(place, level_).inverse;
  const auto row = [&](std::size_t i) {
    return c[i] * m.one + c[i + 1] * m.value + c[i + 2] * m.cx + c[i + 3] * m.cy;
  };
  fit_ = {row(0), row(4), row(8), row(12)};
  return fit_.amplitude > 0.0F;
}

/// At rest: once more at the nearest shift, so that the number hardly depends on the start.
bool MatchedFit::settle() {
  const TemplateBank::Place nearest = bank_.place(found());
  if (!(nearest == place_) && !solve(nearest)) return false;
  return weigh();
}

/// Estimates the noise where the fit came to rest, and goes from the fit at the middle level
/// towards that at the next by as much: a sudden change there would be one of the position.
bool MatchedFit::weigh() {
  sums_ = kernels_.residuals(bank_.view(place_, kMiddleNoise), scratch_.samples.data(), fit_,
                             scratch_.sums.data());
  const TemplateBank::Solver& s = bank_.solver(place_, kMiddleNoise);
  // Variance dark + bright T, least squares with weights w^2; both sums are of w^2 e^2 / 2.
  const double det = s.ww * s.wwtt - s.wwt * s.wwt;
  const double dark =
      std::max(s.wwtt * double(sums_.dark) - s.wwt * double(sums_.bright), kQuantisation * det);
  const double bright = s.ww * double(sums_.bright) - s.wwt * double(sums_.dark);
  const double middle = kNoiseLevels[kMiddleNoise];
  const bool drowned = dark > middle * bright;  // bright may be 0 or, by chance, less
  const std::size_t next = drowned ? kMiddleNoise + 1 : kMiddleNoise - 1;
  const double whole_way = std::log(kNoiseLevels[next] / middle);
  const double way =
      bright > 0.0 ? std::min(std::log(dark / (middle * bright)) / whole_way, 1.0) : 1.0;
  if (way < kLeastWay) return true;
  const TemplateFit here = fit_;
  level_ = int(next);
  if (!solve(TemplateBank::Place(place_))) return false;
  const auto between = [&](float from, float to) { return from + float(way) * (to - from); };
  fit_ = {between(here.background, fit_.background), between(here.amplitude, fit_.amplitude),
          between(here.move_x, fit_.move_x), between(here.move_y, fit_.move_y)};
  const Vec2 move = full_move();
  return std::max(std::abs(move.x), std::abs(move.y)) <= kMaxRest * bank_.step_px();
}

int MatchedFit::count_of(int part) const {
  return bank_.parts().begin[part + 1] - bank_.parts().begin[part];
}

double MatchedFit::mean_of(int part) const {
  const TemplateBank::Parts& parts = bank_.parts();
  float even = 0.0F, odd = 0.0F;  // each addition need not wait for the one before
  int k = parts.begin[part];
  for (; k + 1 < parts.begin[part + 1]; k += 2) {
    even += scratch_.samples[parts.offsets[k]];
    odd += scratch_.samples[parts.offsets[k + 1]];
  }
  if (k < parts.begin[part + 1]) even += scratch_.samples[parts.offsets[k]];
  return double(even + odd) / std::max(1, count_of(part)) - double(fit_.background);
}

/// Light in every direction, and none in a vortex's core. `noise`: variance times weight.
bool MatchedFit::whole(double noise) const {
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
