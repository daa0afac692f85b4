#include "core/spots/point_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace ovws {
namespace {

constexpr double kMaxStepWaves = 0.4;  // RMS: beyond, the derivatives say nothing
constexpr double kNearWaves = 0.004;   // RMS: templates are exact enough from there
constexpr double kFarWaves = 0.05;
constexpr double kReferenceWaves = 0.002, kFarReferenceWaves = 0.01;
constexpr int kReferenceRenderings = 8, kReferenceRounds = 5, kBrightnessRounds = 3;
constexpr double kOffsetSigmas = 3.0;
constexpr double kMaxExcess = 0.1;  // of the weighted light, beyond what the reference leaves
constexpr double kMaxReferenceExcess = 0.15;
// A false minimum leaves more: of a window's width, or over what the reference leaves.
constexpr double kMaxResidual = 0.0005, kMaxOverReference = 2.0;
constexpr int kAmplitudeModes = 9, kFewAmplitudeModes = 5, kManySpots = 19;
constexpr double kAmplitudeRidge = 1e-3;

/// Least squares of modes over the spots' centres; `values` NaN: not known.
std::vector<Mode> smooth_over(const SpotRenderer& renderer, const std::vector<double>& values) {
  const int count = renderer.spots() >= kManySpots ? kAmplitudeModes : kFewAmplitudeModes;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(count + 1, count + 1) * kAmplitudeRidge;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count + 1), row(count + 1);
  for (int i = 0; i < renderer.spots(); ++i) {
    if (std::isnan(values[std::size_t(i)])) continue;
    for (int j = 0; j <= count; ++j) row(j) = zernike(j, renderer.centre(i));
    normal += row * row.transpose();
    right += values[std::size_t(i)] * row;
  }
  const Eigen::VectorXd solved = normal.ldlt().solve(right);
  std::vector<Mode> modes;
  for (int j = 1; j <= count; ++j) modes.push_back({j, solved(j)});  // the mean is the level
  return modes;
}

std::vector<Mode> sum(std::vector<Mode> modes, const std::vector<Mode>& more) {
  if (modes.empty()) return more;
  for (std::size_t k = 0; k < modes.size(); ++k) modes[k].waves += more[k].waves;
  return modes;
}

/// Takes up what the rendering leaves of the brightness of each spot.
void take_up_brightness(const SpotRenderer& renderer, const SpotPass& pass,
                        SpotDeviations& deviations) {
  std::vector<double> ln;
  for (const SpotEstimates& found : pass.found) {
    ln.push_back(found.level > 0.0F ? 0.5 * std::log(double(found.level)) : NAN);
  }
  deviations.ln_amplitude = sum(std::move(deviations.ln_amplitude), smooth_over(renderer, ln));
}

/// Takes up what the rendering leaves of the place of each spot, as far as it is more than noise.
void take_up_places(const SpotPass& pass, SpotDeviations& deviations) {
  deviations.offsets_px.resize(pass.found.size());
  for (std::size_t i = 0; i < pass.found.size(); ++i) {
    const SpotEstimates& found = pass.found[i];
    const SpotTemplates& spot = pass.templates[i];
    if (!(found.level > 0.0F)) continue;
    const Vec2 left = Vec2{double(found.x), double(found.y)} - spot.place_px;
    const double cells = double(found.level) * spot.window.bin * spot.window.bin;
    const double noise = kOffsetSigmas * spot.px_error / cells, size = norm(left);
    if (size <= noise) continue;
    deviations.offsets_px[i] =
        deviations.offsets_px[i] + (1.0 - (noise * noise) / (size * size)) * left;
  }
}

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

Result<void> PointModel::use_reference(const ImageView& image, const PixelNoise& noise,
                                       std::span<const double> start_waves,
                                       std::span<const Mode> fixed) {
  SpotDeviations deviations;
  std::vector<double> waves(start_waves.begin(), start_waves.end());
  for (int round = 0;; ++round) {
    renderer_.set_deviations(deviations);
    auto rendered = renderer_.render(waves, fixed);
    auto found = approach(image, noise, std::move(waves), std::move(rendered), fixed,
                          kReferenceWaves, kReferenceRenderings);
    if (!found) return fail(found.error());
    waves = std::move(found->waves);
    reference_excess_ = found->pass.excess();
    if (round == kReferenceRounds) {
      reference_levels_ = found->pass.levels_dn();
      reference_waves_ = std::vector<double>(waves.size());
      found->waves = waves;
      reference_residual_px_ = fit_at(*found, noise, fixed)->check(image, 0.0).residual_px;
      for (std::size_t k = 0; k < waves.size(); ++k) waves[k] += found->step(Eigen::Index(k));
      reference_waves_ = std::move(waves);
      reference_sigma_waves_ = std::move(found->sigma_waves);
      if (reference_excess_ > kMaxReferenceExcess || found->away_waves > kFarReferenceWaves) break;
      return {};
    }
    // Uneven light moves spots as well, so that places come last.
    if (round < kBrightnessRounds) take_up_brightness(renderer_, found->pass, deviations);
    if (round >= kBrightnessRounds) take_up_places(found->pass, deviations);
  }
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
  double ln = 0.0;
  for (const Mode& mode : renderer_.deviations().ln_amplitude) {
    ln += mode.waves * zernike(mode.j, renderer_.centre(spot));
  }
  return std::exp(ln);
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
