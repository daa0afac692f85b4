#include "core/spots/frame_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/cholesky.hpp"
#include "core/base/decompositions.hpp"

namespace ovws {
namespace {

constexpr double kMinLevel = 0.25;           // of the expected level: a dimmer spot is lost
constexpr int kMaxLostShare = 6;             // at most one of this many spots may be lost
constexpr double kOutlier = 5.0;             // RMS residual of a spot over that of the others
constexpr double kMaxResidualSigmas = 3.0;   // RMS of all spots, standard errors; or, as position,
constexpr double kMaxResidualShare = 0.005;  // fraction of a window's width
constexpr int kMaxPointLostShare = 8;        // as kMaxLostShare, at the operating point
constexpr double kMaxResidualInAir = 2.0;    // standard errors, with known higher modes
constexpr double kMaxPointResidual = 1.3;    // standard errors, at the operating point
// Error of all modes over squared drift, 1 / wave, relative to their noise over that of the best
// mode if it were alone: the same for 18 to 44 modes, charges 0 and 1, and 0.05 to 0.9 wave RMS.
constexpr double kBent = 0.18;
constexpr double kMaxDriftWaves = 0.15;  // RMS; farther ones were not examined
constexpr double kMaxBentWaves = 0.03;   // RMS, or that of the noise; beyond, positions are used
constexpr double kMaxOverCeiling = 1.1;
constexpr double kOverTheory = 2.0;              // variance by higher modes over theory, turbulence
constexpr double kMinNormalConditioning = 1e-9;  // of the normal equations
constexpr double kMaxNoiseGrowth = 5.0;          // of a mode's standard error, by lost spots

/// Converts a level from DN per camera pixel to DN per binned pixel; estimates are relative to it.
double cell_level(const SpotTemplates& spot, double level_dn) {
  return level_dn * spot.window.bin * spot.window.bin;
}

std::vector<SpotTemplates> templates_of(const OperatingPoint& point,
                                        std::span<const RenderedSpot> rendered) {
  std::vector<CellLevel> levels;
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    const double pixels = rendered[i].window.bin * rendered[i].window.bin;
    levels.push_back({point.levels_dn[i] * pixels, point.ceiling_dn * pixels});
  }
  return make_templates(rendered, levels, point.noise, point.estimates);
}

}  // namespace

FrameFit::FrameFit(OperatingPoint point, std::span<const RenderedSpot> rendered,
                   std::vector<int> modes_j)
    : point_(std::move(point)),
      modes_j_(std::move(modes_j)),
      spots_(templates_of(point_, rendered)) {
  const auto modes = Eigen::Index(modes_j_.size());
  std::vector<HigherErrors> higher;
  int usable_spots = 0;
  normal_.setZero(modes, modes);
  for (std::size_t i = 0; i < point_.levels_dn.size(); ++i) {
    const SpotTemplates& spot = spots_.spots()[i];
    const bool usable = point_.levels_dn[i] > 0.0 && spot.estimates() > 0;
    const double level = cell_level(spot, point_.levels_dn[i]);
    rows_.push_back(usable ? Rows(level * spot.per_wave) : Rows::Zero(0, modes));
    higher.push_back(usable ? higher_errors(spot, level, point_.higher_waves) : HigherErrors{});
    whitening_.emplace_back(higher.back().whitening);
    if (whitening_.back().size() > 0) rows_.back() = whitening_.back() * rows_.back();
    normal_.noalias() += rows_.back().transpose() * rows_.back();
    if (!usable) continue;
    ++usable_spots;
    const HigherErrors& errors = higher.back();
    const double variance = errors.own + errors.shared.squaredNorm() / spot.estimates();
    px_error_ += variance * std::pow(spot.px_error / level, 2);
  }
  const SpotWindow& window = spots_.spots().front().window;
  max_residual_px_ = kMaxResidualShare * window.width_px();
  px_error_ = std::sqrt(px_error_ / std::max(usable_spots, 1));
  if (modes == 0) return;
  const Cholesky factors(normal_);
  if (!(factors.reciprocal_condition() > kMinNormalConditioning)) return;
  inverse_ = factors.inverse();
  growth_ = Eigen::VectorXd::Ones(modes);
  if (in_air()) allow_for(higher);
}

/// Computes `growth_`: for each mode, the factor by which the modes above modes_j, which are not
/// fitted, increase the variance of its coefficient. The whitening of a spot's estimates allows for
/// their errors as if they were independent from spot to spot. But a higher mode changes all spots
/// together, so the errors that it causes add up over the spots, and their sum is squared.
void FrameFit::allow_for(std::span<const HigherErrors> higher) {
  const Eigen::Index modes = inverse_.rows();
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(modes, modes), shared;
  for (std::size_t i = 0; i < higher.size(); ++i) {
    if (whitening_[i].size() == 0) continue;
    const Eigen::MatrixXd weights = rows_[i].transpose() * whitening_[i];
    own += higher[i].own * weights * weights.transpose();
    if (shared.size() == 0) shared.setZero(modes, higher[i].shared.cols());
    shared += weights * higher[i].shared;
  }
  if (shared.size() == 0) return;
  const Eigen::MatrixXd covariance =
      inverse_ * (own + kOverTheory * shared * shared.transpose()) * inverse_;
  growth_ = covariance.diagonal().cwiseQuotient(inverse_.diagonal());
}

/// Estimates of a spot, scaled to standard errors of 1 at the operating point's level.
FrameFit::Values FrameFit::values_of(std::size_t i, const SpotEstimates& found) const {
  const double level = cell_level(spots_.spots()[i], point_.levels_dn[i]);
  const Eigen::Index count = rows_[i].rows();
  const Values values =
      level * Eigen::Map<const Eigen::VectorXf>(found.values.data(), count).cast<double>();
  return whitening_[i].size() > 0 ? Values(whitening_[i] * values) : values;
}

FrameFit::Scratch FrameFit::make_scratch() const {
  const auto modes = Eigen::Index(modes_j_.size());
  const auto zero = Eigen::VectorXd::Zero(modes);
  return {zero, zero, zero, Eigen::MatrixXd::Zero(modes, modes),
          std::vector<char>(point_.levels_dn.size())};
}

FrameFit::Measured FrameFit::measure(const ImageView& image) const {
  SpotFit::Scratch pixels = spots_.make_scratch();
  Measured all;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    all.estimates.push_back(spots_.fit(image, i, pixels));
  }
  Scratch scratch = make_scratch();
  all.coefficients.resize(modes_j_.size());
  all.sigma_waves.resize(modes_j_.size());
  all.spots.resize(rows_.size());
  all.frame = solve(all.estimates, scratch, all.coefficients, all.sigma_waves, all.spots);
  return all;
}

const FittedFrame& FrameFit::check(const ImageView& image, double max_residual_px) {
  at_point_ = measure(image).frame;
  // Strict limits: with three spots lost, or with large errors in a dim image, a wrong wavefront
  // can fit the remaining spots.
  const bool small = at_point_.residual < kMaxPointResidual ||
                     (!in_air() && at_point_.residual_px < max_residual_px);
  const bool enough = kMaxPointLostShare * at_point_.lost <= point_.lit;
  at_point_.credible = at_point_.credible && small && enough;
  return at_point_;
}

/// Whether the templates describe a spot: compares the weighted intensity residual with noise.
bool FrameFit::describes(std::size_t i, const SpotEstimates& found, double brightness) const {
  if (rows_[i].rows() == 0 ||
      !(double(found.level) > kMinLevel * brightness * point_.levels_dn[i])) {
    return false;
  }
  const SpotTemplates& spot = spots_.spots()[i];
  if (double(found.level) * spot.brightest_intensity > kMaxOverCeiling * point_.ceiling_dn) {
    return false;  // more pixels may be saturated than at the operating point
  }
  const double scatter = excess_scatter_of(spot, double(found.level));
  return excess_intensity(spot, found) < point_.max_excess + 4.0 * scatter;
}

/// Marks the spots that the templates describe. Returns the brightness of the frame relative to the
/// operating point.
double FrameFit::select(std::span<const SpotEstimates> found, Scratch& scratch,
                        FittedFrame& frame) const {
  double light = 0.0, expected = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (rows_[i].rows() == 0) continue;
    light += double(found[i].level), expected += point_.levels_dn[i];
  }
  const double brightness = expected > 0.0 ? light / expected : 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    scratch.used[i] = describes(i, found[i], brightness);
    frame.used += scratch.used[i] ? 1 : 0;
  }
  frame.lost = point_.lit - frame.used;
  return brightness;
}

FittedFrame FrameFit::solve(std::span<const SpotEstimates> found, Scratch& scratch,
                            std::span<float> coefficients, std::span<float> sigma_waves,
                            std::span<SpotFix> fixes) const {
  std::fill(coefficients.begin(), coefficients.end(), std::numeric_limits<float>::quiet_NaN());
  std::fill(sigma_waves.begin(), sigma_waves.end(), std::numeric_limits<float>::quiet_NaN());
  FittedFrame frame;
  const double brightness = frame.brightness = select(found, scratch, frame);
  for (;;) {
    const bool enough =
        inverse_.size() > 0 && brightness > 0.0 && kMaxLostShare * frame.lost <= point_.lit;
    if (!enough || !solve_normal(found, scratch)) return frame;
    const int outlier = summarise(found, scratch, brightness, frame);
    if (outlier < 0) break;
    scratch.used[std::size_t(outlier)] = 0;
    --frame.used, ++frame.lost;
  }
  frame.drift_waves = scratch.step.norm();
  frame.residual_px = frame.residual * px_error_ / brightness;
  const bool small =
      in_air() ? frame.residual < kMaxResidualInAir
               : frame.residual < kMaxResidualSigmas || frame.residual_px < max_residual_px_;
  const double noise_waves = std::sqrt(growth_.dot(scratch.variances)) / brightness;
  frame.bent_waves = error_by_drift(scratch, noise_waves);
  frame.credible = frame.drift_waves < kMaxDriftWaves &&
                   frame.bent_waves < std::max(kMaxBentWaves, noise_waves) && small;
  const double scale =
      std::max(1.0, frame.residual) / (in_air() ? std::min(1.0, brightness) : brightness);
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    const auto row = Eigen::Index(k);
    const double variance = scale * scale * growth_(row) * scratch.variances(row) +
                            frame.bent_waves * frame.bent_waves / double(coefficients.size());
    coefficients[k] = float(point_.waves[k] - point_.reference_waves[k] + scratch.step(row));
    sigma_waves[k] = float(std::sqrt(variance));
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    fixes[i] = SpotFix{.peak = found[i].peak};
    if (!scratch.used[i]) continue;
    fixes[i].x = found[i].x, fixes[i].y = found[i].y;
    fixes[i].quality = 1.0F;
    fixes[i].level = found[i].level;
  }
  return frame;
}

/// Error of all modes because the templates are not linear, RMS. The part of the step that is noise
/// does not count.
double FrameFit::error_by_drift(const Scratch& scratch, double noise_waves) const {
  const double drift = std::max(0.0, scratch.step.squaredNorm() - noise_waves * noise_waves);
  return kBent * std::sqrt(scratch.variances.sum() * normal_.diagonal().maxCoeff()) * drift;
}

/// Covariance of the modes from the spots in use; null if too few spots determine the modes.
const Eigen::MatrixXd* FrameFit::covariance_by(Scratch& scratch) const {
  const auto is_missing = [&](std::size_t i) { return !scratch.used[i] && rows_[i].rows() > 0; };
  bool all = true;
  for (std::size_t i = 0; i < rows_.size(); ++i) all = all && !is_missing(i);
  if (all) return &inverse_;
  scratch.normal = normal_;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (!is_missing(i)) continue;
    for (Eigen::Index r = 0; r < rows_[i].rows(); ++r) {
      scratch.normal.noalias() -= rows_[i].row(r).transpose() * rows_[i].row(r);
    }
  }
  if (!invert_positive(scratch.normal)) return nullptr;
  const auto limits = kMaxNoiseGrowth * kMaxNoiseGrowth * inverse_.diagonal().array();
  return (scratch.normal.diagonal().array() <= limits).all() ? &scratch.normal : nullptr;
}

/// Solves the normal equations for scratch.step and its variances. False: modes undetermined.
bool FrameFit::solve_normal(std::span<const SpotEstimates> found, Scratch& scratch) const {
  const Eigen::MatrixXd* const covariance = covariance_by(scratch);
  if (covariance == nullptr) return false;
  scratch.right.setZero();
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!scratch.used[i]) continue;
    scratch.right.noalias() += rows_[i].transpose() * values_of(i, found[i]);
  }
  scratch.step.noalias() = *covariance * scratch.right;
  scratch.variances = covariance->diagonal();
  return true;
}

/// Squared residual of a spot's estimates after the fit of the modes, in squared standard errors.
double FrameFit::left_of(std::size_t i, const SpotEstimates& found, const Scratch& scratch) const {
  Values left = values_of(i, found);
  left.noalias() -= rows_[i] * scratch.step;
  return left.squaredNorm();
}

/// Computes the residual of all spots; returns the worst outlier, or -1. Estimates are scaled to
/// the level of the operating point, so a dimmer frame has larger errors by noise.
int FrameFit::summarise(std::span<const SpotEstimates> found, const Scratch& scratch,
                        double brightness, FittedFrame& frame) const {
  const double scale = in_air() ? 1.0 : brightness;
  double sum = 0.0, most = 0.0;
  Eigen::Index count = 0;
  int worst = -1;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!scratch.used[i]) continue;
    const double left = scale * scale * left_of(i, found[i], scratch);
    sum += left, count += rows_[i].rows();
    if (left > most) most = left, worst = int(i);
  }
  const auto free = double(count - scratch.step.size());
  frame.residual = free > 0.0 ? std::sqrt(sum / free) : 0.0;
  const double estimates = worst >= 0 ? double(rows_[std::size_t(worst)].rows()) : 1.0;
  const double others = (sum - most) / std::max(1.0, double(count) - estimates);
  return most > estimates * kOutlier * kOutlier * std::max(1.0, others) ? worst : -1;
}

}  // namespace ovws
