#include "core/spots/point_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "core/spots/local_fields.hpp"

namespace ovws {
namespace {

constexpr double kMaxStepWaves = 0.4;  // RMS: longer steps are shortened, derivatives do not hold
constexpr double kNearWaves = 0.004;   // RMS distance at which templates are exact enough
constexpr double kFarWaves = 0.05;
constexpr double kReferenceWaves = 0.002, kFarReferenceWaves = 0.01;
constexpr int kReferenceRenderings = 8, kReferenceRounds = 16;
constexpr double kNoiseOnly = 1.25, kStalled = 0.98;  // chi-squared per binned pixel; its ratio
constexpr std::size_t kNoises = 8;
constexpr double kMaxExcess = 0.1;  // weighted residual, fraction, beyond the reference's
constexpr double kMaxReferenceExcess = 0.15;
// Higher modes, above the measured ones: limits of their RMS, and of predicted over found excess
// intensity. That ratio is 0.12 to 1.7 in turbulent air, and over 2 at false minima.
constexpr double kUsualHigherWaves = 0.01, kLeastHigherWaves = 0.001, kMaxHigherWaves = 0.03;
constexpr double kMinOverShapes = 0.1, kMaxOverShapes = 2.0, kScatters = 2.0, kSmallExcess = 5e-4;
constexpr double kFarOver = 2.0, kUnsettled = 0.1;
constexpr int kHigherRounds = 4, kHigherRenderings = 5;
// Limits against false minima: a fit is accepted up to the larger one.
constexpr double kMaxPositionResidual = 0.0005;  // as position error, fraction of window width
// The same at the end of a search that lost no spot, whose shapes differ less than by strong air.
constexpr double kMaxWholeResidual = 0.002, kMaxWholeExcess = 0.002;
constexpr double kMaxOverReference = 2.0;  // ratio of the residual to that of the reference's fit

}  // namespace

/// Gauss-Newton iteration of the coefficients, from `waves` on, until the next step would be at
/// most `near_waves` long, or for `renderings`.
Result<PointModel::Found> PointModel::approach(const ImageView& image, const NoiseFrom& noise_from,
                                               std::vector<double> waves,
                                               std::span<const Mode> fixed, double near_waves,
                                               int renderings) {
  for (int k = 1;; ++k) {
    Found found;
    ++renderings_;
    found.rendered = renderer_.render(waves, fixed);
    found.noise = noise_from(found.rendered);
    found.pass = fit_spots(image, found.rendered, found.noise, estimates_);
    found.waves = std::move(waves);
    const auto step = damped_step(found.pass);
    if (!step) {
      return fail(
          Errc::refused, "image",
          "the spots do not determine the modes: check exposure, focus and optics, or set a "
          "smaller tracking.mode_count");
    }
    found.step = step->waves;
    found.away_waves = step->waves.norm();
    for (const double variance : step->covariance.diagonal()) {
      found.sigma_waves.push_back(std::sqrt(variance));
    }
    if (found.away_waves <= near_waves || k == renderings) return found;
    waves = std::move(found.waves);
    const double damping = std::min(1.0, kMaxStepWaves / found.away_waves);
    for (std::size_t j = 0; j < waves.size(); ++j)
      waves[j] += damping * step->waves(Eigen::Index(j));
  }
}

Result<PointModel::Found> PointModel::at_reference(const ImageView& image, const PixelNoise& noise,
                                                   std::vector<double> waves,
                                                   std::span<const Mode> fixed,
                                                   const SpotDeviations& deviations) {
  renderer_.set_deviations(deviations);
  return approach(
      image, [&](const auto&) { return noise; }, std::move(waves), fixed, kReferenceWaves,
      kReferenceRenderings);
}

/// `claimed` is of other frames and may be that of changing light.
PixelNoise PointModel::noise_in_reference(const ImageView& image, const PixelNoise& claimed,
                                          std::span<const RenderedSpot> rendered) {
  PixelNoise shown = noise_of(image, rendered);
  shown.saturated_dn = claimed.saturated_dn;
  reference_levels_ = fit_spots(image, rendered, claimed, estimates_).levels_dn();
  return quieter(claimed, shown);
}

Result<void> PointModel::use_reference(const ImageView& image, const PixelNoise& claimed,
                                       std::span<const double> start_waves,
                                       std::span<const Mode> fixed) {
  renderings_ = 1;
  use_model();
  SpotDeviations deviations, best;
  std::vector<double> waves(start_waves.begin(), start_waves.end()), best_waves, px_per_wave;
  const PixelNoise noise = noise_in_reference(image, claimed, renderer_.render(waves, fixed));
  for (int i = 0; i < renderer_.spots(); ++i) px_per_wave.push_back(renderer_.px_per_wave(i));
  double least_chi2 = std::numeric_limits<double>::infinity();
  for (int round = 0; round <= kReferenceRounds; ++round) {
    auto found = at_reference(image, noise, std::move(waves), fixed, deviations);
    if (!found) return fail(found.error());
    const double chi2 = found->pass.chi2();
    const bool stalled = chi2 > kStalled * least_chi2;
    waves = found->waves;
    if (chi2 < least_chi2) least_chi2 = chi2, best = deviations, best_waves = waves;
    if (chi2 < kNoiseOnly || stalled) break;
    take_up_fields(image, found->pass, found->rendered,
                   renderer_.per_field(found->rendered, found->waves, fixed), noise, px_per_wave,
                   deviations);
  }
  if (best_waves.empty()) best_waves = std::move(waves);
  auto found = at_reference(image, noise, std::move(best_waves), fixed, best);
  if (!found) return fail(found.error());
  return count_from(*found, image, fixed);
}

/// Sets the zero of the coefficients: what a FrameFit measures in the reference's image. Model
/// errors are then equal in reference and frames, and cancel.
Result<void> PointModel::count_from(const Found& found, const ImageView& image,
                                    std::span<const Mode> fixed) {
  reference_excess_ = found.pass.excess();
  reference_levels_ = found.pass.levels_dn();
  reference_waves_ = std::vector<double>(found.waves.size());
  const auto fit = fit_at(found, fixed);
  reference_residual_px_ = fit->check(image, 0.0).residual_px;
  const std::vector<float> measured = fit->measure(image).coefficients;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const double step = found.waves[k] + found.step(Eigen::Index(k));
    reference_waves_[k] = std::isfinite(measured[k]) ? double(measured[k]) : step;
  }
  reference_sigma_waves_ = found.sigma_waves;
  if (reference_excess_ <= kMaxReferenceExcess && found.away_waves <= kFarReferenceWaves) return {};
  return fail(
      Errc::refused, "reference",
      "the diffraction model does not explain the reference's image: check the focus, and that the "
      "keys optics.* are those of the bench, then take a new reference");
}

void PointModel::end_correction() {
  renderer_.set_correction({});
  corrected_at_.clear();
}

void PointModel::correct_by(const MeasuredShapes& measured, std::span<const double> coefficients) {
  end_correction();
  std::vector<double> at_waves = from_reference(coefficients);
  auto made = SpotCorrection::make(renderer_, measured, at_waves);
  if (!made) return;
  renderer_.set_correction(std::move(made));
  corrected_at_ = std::move(at_waves);
}

void PointModel::use_model() {
  end_correction();
  renderer_.set_deviations({});
  reference_waves_.assign(renderer_.modes_j().size(), 0.0);
  reference_sigma_waves_ = reference_waves_;
  reference_levels_.assign(std::size_t(renderer_.spots()), 1.0);
  reference_excess_ = reference_residual_px_ = 0.0;
}

std::vector<double> PointModel::from_reference(std::span<const double> coefficients) const {
  std::vector<double> waves(reference_waves_);
  for (std::size_t k = 0; k < waves.size(); ++k) waves[k] += coefficients[k];
  return waves;
}

/// The smaller of two noise estimates, at the light of a usual spot.
PixelNoise PointModel::quieter(const PixelNoise& a, const PixelNoise& b) const {
  const double usual_dn = reference_levels_.empty() ? 0.0 : std::ranges::max(reference_levels_);
  return a.variance(usual_dn, 1) < b.variance(usual_dn, 1) ? a : b;
}

Result<std::shared_ptr<const FrameFit>> PointModel::templates(std::span<const ImageView> images,
                                                              Starts starts,
                                                              std::span<const Mode> fixed,
                                                              int renderings) {
  std::optional<PixelNoise> least;
  const auto noise_from = [&](std::span<const RenderedSpot> rendered) {
    const PixelNoise now = noise_of(images, rendered);
    least = least ? quieter(*least, now) : now;
    return std::accumulate(noises_.begin(), noises_.end(), *least,
                           [&](const auto& a, const auto& b) { return quieter(a, b); });
  };
  auto fit = found_in(images.back(), noise_from, starts, fixed, renderings);
  if (fit && least) noises_.push_back(*least);
  if (noises_.size() > kNoises) noises_.pop_front();
  return fit;
}

Result<std::shared_ptr<const FrameFit>> PointModel::templates(const ImageView& image, Starts starts,
                                                              std::span<const Mode> fixed,
                                                              int renderings) {
  const auto noise_from = [&](std::span<const RenderedSpot> rendered) {
    return noise_of(image, rendered);
  };
  return found_in(image, noise_from, starts, fixed, renderings);
}

Result<std::shared_ptr<const FrameFit>> PointModel::templates(const ImageView& image,
                                                              const PixelNoise& noise,
                                                              Starts starts,
                                                              std::span<const Mode> fixed,
                                                              int renderings) {
  return found_in(
      image, [&](const auto&) { return noise; }, starts, fixed, renderings);
}

Result<std::shared_ptr<const FrameFit>> PointModel::found_in(const ImageView& image,
                                                             const NoiseFrom& noise_from,
                                                             Starts starts,
                                                             std::span<const Mode> fixed,
                                                             int renderings) {
  Result<std::shared_ptr<const FrameFit>> fit = fail(Errc::refused, "image", "no start is known");
  std::optional<Found> near;
  std::shared_ptr<const FrameFit> whole;
  renderings_ = 0;
  for (const std::vector<double>& start : starts) {
    auto found = approach(image, noise_from, from_reference(start), fixed, kNearWaves, renderings);
    fit = found ? accepted(*found, image, fixed, kMaxPositionResidual) : fail(found.error());
    if (fit) return fit;
    if (!found || found->away_waves > kFarWaves) continue;
    whole = accepted_whole(*found, image, fixed);
    if (!whole && near && near->pass.chi2() < found->pass.chi2()) continue;
    near = std::move(*found);
    if (whole) break;
  }
  if (!near) return fit;
  if (const auto rough = with_higher_modes(image, std::move(*near), fixed)) {
    auto in_air = accepted(*rough, image, fixed, kMaxPositionResidual);
    if (in_air || !whole) return in_air;
  }
  if (whole) return whole;
  return fit;
}

/// Templates of a search that has arrived and lost no spot. A false minimum loses spots, so these
/// may leave more than others: errors of a model that does not quite describe the bench.
std::shared_ptr<const FrameFit> PointModel::accepted_whole(const Found& found,
                                                           const ImageView& image,
                                                           std::span<const Mode> fixed) const {
  const double excess = found.pass.excess() - reference_excess_;
  if (found.away_waves > kNearWaves || excess > kMaxWholeExcess) return nullptr;
  auto fit = accepted(found, image, fixed, kMaxWholeResidual);
  return fit && (*fit)->at_point().lost == 0 ? std::move(*fit) : nullptr;
}

/// Continues the search with errors by higher modes, whose strength the estimates give. None: the
/// spots contradict each other.
std::optional<PointModel::Found> PointModel::with_higher_modes(const ImageView& image, Found found,
                                                               std::span<const Mode> fixed) {
  double higher_waves = kUsualHigherWaves;
  for (int k = 1;; ++k) {
    for (int round = 0; round < kHigherRounds; ++round) {
      found.pass.higher_waves = higher_waves;
      const auto step = step_from(found.pass);
      if (!step) return std::nullopt;
      found.step = step->waves;
      higher_waves = std::max(kLeastHigherWaves, higher_waves_of(found.pass, *step));
    }
    found.away_waves = found.step.norm();
    const bool settled =
        std::abs(higher_waves - found.pass.higher_waves) <= kUnsettled * higher_waves;
    const bool arrived = found.away_waves <= kNearWaves;
    if (arrived && settled && are_explained_by(higher_waves, found)) return found;
    if (arrived || k == kHigherRenderings || found.away_waves > kFarWaves ||
        higher_waves > kFarOver * kMaxHigherWaves) {
      return std::nullopt;
    }
    for (std::size_t j = 0; j < found.waves.size(); ++j) {
      found.waves[j] += found.step(Eigen::Index(j));
    }
    found.rendered = renderer_.render(found.waves, fixed);
    found.pass = fit_spots(image, found.rendered, found.noise, estimates_);
    ++renderings_;
  }
}

/// Whether higher modes of this RMS explain how far the spots are from their rendered shapes. Spots
/// of correct shape that contradict each other indicate a false minimum.
bool PointModel::are_explained_by(double higher_waves, const Found& found) const {
  double rest = 0.0, lit = 0.0;
  for (std::size_t i = 0; i < found.rendered.size(); ++i) {
    if (!(found.pass.found[i].level > 0.0F)) continue;
    rest += found.rendered[i].higher_rest, lit += 1.0;
  }
  const double moved = rest / lit * std::pow(2.0 * std::numbers::pi * higher_waves, 2);
  const double left = found.pass.excess() - reference_excess_;
  const double by_chance = kScatters * found.pass.excess_scatter();
  const bool weak = higher_waves <= kUsualHigherWaves;  // too weak to be seen in a dim image
  const bool enough = moved < kMaxOverShapes * (weak ? left + by_chance : left);
  const bool not_more = left - by_chance < std::max(moved / kMinOverShapes, kSmallExcess);
  return higher_waves < kMaxHigherWaves && enough && not_more && (weak || left > by_chance);
}

Result<std::shared_ptr<const FrameFit>> PointModel::accepted(const Found& found,
                                                             const ImageView& image,
                                                             std::span<const Mode> fixed,
                                                             double max_residual) const {
  if (!(found.pass.excess() < allowed_excess()) || found.away_waves > kFarWaves) {
    return fail(
        Errc::refused, "image",
        "the spots differ from those of the model: check exposure, focus, and optics in the "
        "configuration");
  }
  auto fit = fit_at(found, fixed);
  const double allowed_px = std::max(max_residual * found.rendered.front().window.width_px(),
                                     kMaxOverReference * reference_residual_px_);
  const FittedFrame& found_again = fit->check(image, allowed_px);
  // Undamped step: the earlier steps were damped. In a dim image, a large undamped step may be the
  // only sign of a wrong wavefront.
  if (found_again.drift_waves > kFarWaves) {
    return fail(
        Errc::refused, "image",
        "all renderings of the search found no wavefront: check exposure, focus and optics");
  }
  if (!found_again.credible) {
    return fail(Errc::refused, "image",
                "too few spots look as the model renders them: check exposure, focus and optics");
  }
  return fit;
}

double PointModel::amplitude(int spot) const {
  const auto& fields = renderer_.deviations().fields;
  return fields.empty() ? 1.0 : std::abs(1.0 + fields[std::size_t(spot)][0]);
}

double PointModel::allowed_excess() const {
  return kMaxExcess + kMaxOverReference * std::max(0.0, reference_excess_);
}

std::shared_ptr<FrameFit> PointModel::fit_at(const Found& found,
                                             std::span<const Mode> fixed) const {
  OperatingPoint point;
  point.waves = found.waves;
  point.reference_waves = reference_waves_;
  point.fixed.assign(fixed.begin(), fixed.end());
  point.deviations = renderer_.deviations();
  point.corrected_at = corrected_at_;
  point.noise = found.noise;
  point.levels_dn = found.pass.levels_dn();
  for (std::size_t i = 0; i < point.levels_dn.size(); ++i) {
    const bool lit = reference_levels_[i] > 0.0;
    if (!lit) point.levels_dn[i] = 0.0;
    point.lit += lit ? 1 : 0;
  }
  point.ceiling_dn = found.pass.ceiling_dn;
  point.estimates = estimates_;
  point.higher_waves = found.pass.higher_waves;
  point.max_excess = allowed_excess();
  return std::make_shared<FrameFit>(std::move(point), found.rendered, renderer_.modes_j());
}

}  // namespace ovws
