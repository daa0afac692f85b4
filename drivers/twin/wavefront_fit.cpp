#include "drivers/twin/wavefront_fit.hpp"

#include <cmath>
#include <numbers>

#include "core/base/decompositions.hpp"

namespace ovws::twin {
namespace {

constexpr int kModes = PupilBlocks::kModes;
constexpr int kGradientFits = 3, kPhaseFits = 20;
constexpr double kConvergedWaves = 1e-7;
constexpr double kOutlierWaves = 0.4, kMaxOutlierShare = 0.01;

double phase_waves(std::complex<double> phasor) {
  return std::arg(phasor) / (2.0 * std::numbers::pi);
}

std::vector<Mode> modes_of(const Eigen::VectorXd& waves) {
  std::vector<Mode> modes;
  for (int j = 0; j < waves.size(); ++j) modes.push_back({j, waves[j]});
  return modes;
}

/// Weighted least-squares fit of the modes, without piston, to the phase differences between
/// neighbouring blocks.
Eigen::VectorXd fit_gradients(const PupilBlocks& blocks, const Eigen::VectorXcd& sums) {
  constexpr int kFitted = kModes - 1;
  Eigen::MatrixXd normal = 1e-12 * Eigen::MatrixXd::Identity(kFitted, kFitted);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(kFitted);
  for (const auto& [a, b] : blocks.neighbours()) {
    const std::complex<double> ratio = std::conj(sums[a]) * sums[b];
    const Eigen::VectorXd step = (blocks.modes().row(b) - blocks.modes().row(a)).tail(kFitted);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(step, std::abs(ratio));
    rhs += std::abs(ratio) * phase_waves(ratio) * step;
  }
  Eigen::VectorXd modes = Eigen::VectorXd::Zero(kModes);
  modes.tail(kFitted) = Cholesky(normal).solve(rhs);
  return modes;
}

/// Phase of each block in waves, within half a wave of the mean phase.
Eigen::VectorXd phases(const Eigen::VectorXcd& sums) {
  const std::complex<double> mean = sums.sum();
  Eigen::VectorXd waves(sums.size());
  for (Eigen::Index b = 0; b < sums.size(); ++b) waves[b] = phase_waves(sums[b] * std::conj(mean));
  return waves.array() + phase_waves(mean);
}

}  // namespace

WavefrontFit fit_wavefront(const PupilBlocks& blocks, const Image<std::complex<float>>& field) {
  const Eigen::MatrixXd& modes = blocks.modes();
  const Eigen::MatrixXd weighted = blocks.weights().asDiagonal() * modes;
  const Cholesky normal(modes.transpose() * weighted);
  Eigen::VectorXd estimate = Eigen::VectorXd::Zero(kModes);
  for (int n = 0; n < kGradientFits; ++n) {
    estimate += fit_gradients(blocks, blocks.sums(&field, modes_of(estimate)));
  }
  Eigen::VectorXd residual;
  for (int n = 0; n < kPhaseFits; ++n) {
    residual = phases(blocks.smoothed(blocks.sums(&field, modes_of(estimate))));
    const Eigen::VectorXd update = normal.solve(weighted.transpose() * residual);
    estimate += update;
    residual -= modes * update;
    if (update.cwiseAbs().maxCoeff() < kConvergedWaves) break;
  }
  WavefrontFit fit{modes_of(estimate), residual, false};
  const Eigen::ArrayXd outliers = (residual.array().abs() > kOutlierWaves).cast<double>();
  fit.unwrapped = estimate.allFinite() && (outliers * blocks.weights().array()).sum() <=
                                              kMaxOutlierShare * blocks.weights().sum();
  return fit;
}

}  // namespace ovws::twin
