#include "core/spots/point_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/spots/local_fields.hpp"

namespace ovws {
namespace {

constexpr double kMaxStepWaves = 0.4;  // RMS: beyond, the derivatives say nothing
constexpr double kNearWaves = 0.004;   // RMS: templates are exact enough from there
constexpr double kFarWaves = 0.05;
constexpr double kReferenceWaves = 0.002, kFarReferenceWaves = 0.01;
constexpr int kReferenceRenderings = 8, kReferenceRounds = 16;
constexpr double kNoiseOnly = 1.25, kStalled = 0.98;  // of chi-squared per cell
constexpr double kMaxExcess = 0.1;  // of the weighted light, beyond what the reference leaves
constexpr double kMaxReferenceExcess = 0.15;
// A false minimum leaves more: of a window's width, or over what the reference leaves.
constexpr double kMaxResidual = 0.0005, kMaxOverReference = 2.0;

}  // namespace

/// Gauss-Newton until the image is near the rendering, which is `rendered` at first.
Result<PointModel::Found> PointModel::approach(const ImageView& image, const PixelNoise& noise,
                                               std::vector<double> waves,
                                               std::vector<RenderedSpot> rendered,
                                               std::span<const Mode> fixed, double near_waves,
                                               int renderings) {
  for (int k = 1;; ++k) {
    Found found;
    renderings_ = k;
    found.rendered = k == 1 ? std::move(rendered) : renderer_.render(waves, fixed);
    found.pass = fit_spots(image, found.rendered, noise, estimates_);
    found.waves = std::move(waves);
    const auto step = damped_step(found.pass);
    if (!step) return fail(Errc::refused, "image", "the spots do not determine the modes");
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
  auto rendered = renderer_.render(waves, fixed);
  return approach(image, noise, std::move(waves), std::move(rendered), fixed, kReferenceWaves,
                  kReferenceRenderings);
}

Result<void> PointModel::use_reference(const ImageView& image, const PixelNoise& noise,
                                       std::span<const double> start_waves,
                                       std::span<const Mode> fixed) {
  SpotDeviations deviations, best;
  std::vector<double> waves(start_waves.begin(), start_waves.end()), best_waves, px_per_wave;
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
  return count_from(*found, image, noise, fixed);
}

/// Coefficients count from what frames measure in this image, so that what the model leaves is the
/// same in both.
Result<void> PointModel::count_from(const Found& found, const ImageView& image,
                                    const PixelNoise& noise, std::span<const Mode> fixed) {
  reference_excess_ = found.pass.excess();
  reference_levels_ = found.pass.levels_dn();
  reference_waves_ = std::vector<double>(found.waves.size());
  const auto fit = fit_at(found, noise, fixed);
  reference_residual_px_ = fit->check(image, 0.0).residual_px;
  const std::vector<float> measured = fit->measure(image).coefficients;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const double step = found.waves[k] + found.step(Eigen::Index(k));
    reference_waves_[k] = std::isfinite(measured[k]) ? double(measured[k]) : step;
  }
  reference_sigma_waves_ = found.sigma_waves;
  if (reference_excess_ <= kMaxReferenceExcess && found.away_waves <= kFarReferenceWaves) return {};
  return fail(Errc::refused, "reference", "the model does not explain the reference's image");
}

void PointModel::use_model() {
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

Result<std::shared_ptr<const FrameFit>> PointModel::templates(std::span<const ImageView> images,
                                                              std::span<const double> coefficients,
                                                              std::span<const Mode> fixed,
                                                              int renderings) {
  std::vector<double> waves = from_reference(coefficients);
  auto rendered = renderer_.render(waves, fixed);
  const PixelNoise noise = noise_of(images, rendered);
  auto found = approach(images.back(), noise, std::move(waves), std::move(rendered), fixed,
                        kNearWaves, renderings);
  if (!found) return fail(found.error());
  return accepted(*found, images.back(), noise, fixed);
}

Result<std::shared_ptr<const FrameFit>> PointModel::templates(const ImageView& image,
                                                              const PixelNoise& noise,
                                                              std::span<const double> coefficients,
                                                              std::span<const Mode> fixed,
                                                              int renderings) {
  std::vector<double> waves = from_reference(coefficients);
  auto rendered = renderer_.render(waves, fixed);
  auto found =
      approach(image, noise, std::move(waves), std::move(rendered), fixed, kNearWaves, renderings);
  if (!found) return fail(found.error());
  return accepted(*found, image, noise, fixed);
}

Result<std::shared_ptr<const FrameFit>> PointModel::accepted(const Found& found,
                                                             const ImageView& image,
                                                             const PixelNoise& noise,
                                                             std::span<const Mode> fixed) const {
  if (!(found.pass.excess() < allowed_excess()) || found.away_waves > kFarWaves) {
    return fail(Errc::refused, "image", "the spots do not look as rendered");
  }
  auto fit = fit_at(found, noise, fixed);
  const SpotWindow& window = found.rendered.front().window;
  const double allowed_px =
      std::max(kMaxResidual * window.side * window.bin, kMaxOverReference * reference_residual_px_);
  if (!fit->check(image, allowed_px).credible) {
    return fail(Errc::refused, "image", "too few spots look as rendered");
  }
  return fit;
}

double PointModel::amplitude(int spot) const {
  const auto& fields = renderer_.deviations().fields;
  return fields.empty() ? 1.0 : std::abs(1.0 + fields[std::size_t(spot)][0]);
}

double PointModel::allowed_excess() const {
  return kMaxExcess + kMaxOverReference * reference_excess_;
}

std::shared_ptr<FrameFit> PointModel::fit_at(const Found& found, const PixelNoise& noise,
                                             std::span<const Mode> fixed) const {
  OperatingPoint point;
  point.waves = found.waves;
  point.reference_waves = reference_waves_;
  point.fixed.assign(fixed.begin(), fixed.end());
  point.deviations = renderer_.deviations();
  point.noise = noise;
  point.levels_dn = found.pass.levels_dn();
  for (std::size_t i = 0; i < point.levels_dn.size(); ++i) {
    const bool lit = reference_levels_[i] > 0.0;
    if (!lit) point.levels_dn[i] = 0.0;
    point.lit += lit ? 1 : 0;
  }
  point.ceiling_dn = found.pass.ceiling_dn;
  point.estimates = estimates_;
  point.max_excess = allowed_excess();
  return std::make_shared<FrameFit>(std::move(point), found.rendered, renderer_.modes_j());
}

}  // namespace ovws
