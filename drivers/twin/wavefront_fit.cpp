#include "drivers/twin/wavefront_fit.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

namespace ovws::twin {
namespace {

constexpr int kModes = PupilBlocks::kModes;
constexpr int kGradientFits = 3, kPhaseFits = 20;
constexpr double kStillWaves = 1e-7;
constexpr double kFarWaves = 0.4, kMostFar = 0.01;

double waves_of(std::complex<double> phasor) {
  return std::arg(phasor) / (2.0 * std::numbers::pi);
}

std::vector<Mode> modes_of(const Eigen::VectorXd& waves) {
  std::vector<Mode> modes;
  for (int j = 0; j < waves.size(); ++j) modes.push_back({j, waves[j]});
  return modes;
}

/// Weighted least-squares fit of the modes, without piston, to phase differences between
/// neighbours.
Eigen::VectorXd fit_gradients(const PupilBlocks& blocks, const Eigen::VectorXcd& sums) {
  constexpr int kTold = kModes - 1;
  using Matrix = Eigen::Matrix<double, kTold, kTold>;
  Matrix normal = 1e-12 * Matrix::Identity();
  Eigen::Matrix<double, kTold, 1> right = Eigen::Matrix<double, kTold, 1>::Zero();
  for (const auto& [a, b] : blocks.neighbours()) {
    const std::complex<double> turn = std::conj(sums[a]) * sums[b];
    const Eigen::Matrix<double, kTold, 1> step =
        (blocks.modes().row(b) - blocks.modes().row(a)).tail<kTold>();
    normal.selfadjointView<Eigen::Lower>().rankUpdate(step, std::abs(turn));
    right += std::abs(turn) * waves_of(turn) * step;
  }
  Eigen::VectorXd modes = Eigen::VectorXd::Zero(kModes);
  modes.tail<kTold>() = normal.selfadjointView<Eigen::Lower>().llt().solve(right);
  return modes;
}

/// Phase of each block in waves, within half a wave of the mean phase.
Eigen::VectorXd phases(const Eigen::VectorXcd& sums) {
  const std::complex<double> mean = sums.sum();
  Eigen::VectorXd waves(sums.size());
  for (Eigen::Index b = 0; b < sums.size(); ++b) waves[b] = waves_of(sums[b] * std::conj(mean));
  return waves.array() + waves_of(mean);
}

}  // namespace

WavefrontFit fit_wavefront(const PupilBlocks& blocks, const Image<std::complex<float>>& field) {
  const Eigen::MatrixXd& modes = blocks.modes();
  const Eigen::MatrixXd weighted = blocks.weights().asDiagonal() * modes;
  const Eigen::LLT<Eigen::MatrixXd> normal(modes.transpose() * weighted);
  Eigen::VectorXd found = Eigen::VectorXd::Zero(kModes);
  for (int n = 0; n < kGradientFits; ++n) {
    found += fit_gradients(blocks, blocks.sums(&field, modes_of(found)));
  }
  Eigen::VectorXd rest;
  for (int n = 0; n < kPhaseFits; ++n) {
    rest = phases(blocks.smoothed(blocks.sums(&field, modes_of(found))));
    const Eigen::VectorXd more = normal.solve(weighted.transpose() * rest);
    found += more;
    rest -= modes * more;
    if (more.cwiseAbs().maxCoeff() < kStillWaves) break;
  }
  WavefrontFit fit{modes_of(found), rest, false};
  const Eigen::ArrayXd far = (rest.array().abs() > kFarWaves).cast<double>();
  fit.unwrapped = found.allFinite() &&
                  (far * blocks.weights().array()).sum() <= kMostFar * blocks.weights().sum();
  return fit;
}

}  // namespace ovws::twin
