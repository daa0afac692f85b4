#include "core/control/predictor.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace ovws {
namespace {

/// Slow motion of up to some waves: weak against any identified part, and unlimited in time against
/// a step of the loop.
constexpr Oscillator kDrift{.hz = 0.005, .damping = 1.0, .rms_waves = 1.0};
constexpr double kLeastNoiseWaves = 1e-4;  // with less, the filter is ill-conditioned
constexpr int kMostTurns = 5000;           // until the filter is steady
constexpr double kSteady = 1e-9;           // relative change of the innovation's variance

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return std::max(0.0, 1e-9 * double(to_ns - from_ns));
}

}  // namespace

Predictor::Predictor(const Disturbance& disturbance, double correction_waves)
    : parts_(disturbance.parts),
      noise_waves_(disturbance.noise_waves),
      first_waves_(correction_waves) {
  parts_.push_back(kDrift);
  stationary_.resize(2 * Eigen::Index(parts_.size()));
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    stationary_.segment<2>(2 * Eigen::Index(i)) = parts_[i].variances();
  }
  state_ = State::Zero(stationary_.size());
  covariance_ = stationary_.asDiagonal();
}

Predictor::Transition Predictor::transition(double seconds) const {
  Transition all;
  for (std::size_t i = 0; i < parts_.size(); ++i) all[i] = parts_[i].transition(seconds);
  return all;
}

Predictor::State Predictor::moved(const Transition& by, const State& state) const {
  State after(state.size());
  for (Eigen::Index i = 0; i < state.size(); i += 2) {
    after.segment<2>(i) = by[std::size_t(i / 2)] * state.segment<2>(i);
  }
  return after;
}

Predictor::Square Predictor::driven(Square covariance, const Transition& by) const {
  covariance.diagonal() -= stationary_;  // what is known more than nothing
  for (Eigen::Index i = 0; i < covariance.rows(); i += 2) {
    covariance.middleRows<2>(i) = (by[std::size_t(i / 2)] * covariance.middleRows<2>(i)).eval();
  }
  for (Eigen::Index i = 0; i < covariance.cols(); i += 2) {
    covariance.middleCols<2>(i) =
        (covariance.middleCols<2>(i) * by[std::size_t(i / 2)].transpose()).eval();
  }
  covariance.diagonal() += stationary_;
  return covariance;
}

double Predictor::position_of(const State& state) const {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < state.size(); i += 2) sum += state[i];
  return sum;
}

Predictor::State Predictor::positions_of(const Square& covariance) const {
  State sum = State::Zero(covariance.rows());
  for (Eigen::Index i = 0; i < covariance.cols(); i += 2) sum += covariance.col(i);
  return sum;
}

double Predictor::noise_variance(double sigma_waves) const {
  return std::pow(std::max({sigma_waves, noise_waves_, kLeastNoiseWaves}), 2);
}

void Predictor::observe(const ModeSample& sample) {
  const std::int64_t now_ns = std::max(t_ns_, sample.t_ns);
  if (t_ns_ != 0) {
    const Transition by = transition(seconds_between(t_ns_, now_ns));
    state_ = moved(by, state_);
    covariance_ = driven(covariance_, by);
  }
  t_ns_ = now_ns;
  const double disturbance = sample.residual_waves + sample.shown_waves;
  const double innovation = disturbance - position_of(state_);
  const double noise = noise_variance(sample.sigma_waves);
  const double expected = position_of(positions_of(covariance_)) + noise;
  const bool far = innovation * innovation > kJump * kJump * expected;
  const double before = std::exchange(skipped_, 0.0);
  if (far && before * innovation <= 0.0) {
    skipped_ = innovation;  // a jump, or a single frame that is wrong: the next one tells
    return;
  }
  if (far) {
    const Eigen::Index drift = covariance_.rows() - 2;
    covariance_(drift, drift) += innovation * innovation;
  }
  const State towards = positions_of(covariance_);
  const double variance = position_of(towards) + noise;
  state_ += innovation / variance * towards;
  covariance_ -= towards * towards.transpose() / variance;
}

double Predictor::step(std::int64_t t_ns, double limit_waves) {
  const double waves = t_ns_ == 0
                           ? first_waves_
                           : position_of(moved(transition(seconds_between(t_ns_, t_ns)), state_));
  return std::clamp(waves, -limit_waves, limit_waves);
}

Predictor::State Predictor::steady_gain(const Transition& by) const {
  const double noise = noise_variance(0.0);
  Square covariance = stationary_.asDiagonal();
  State gain;
  double before = 0.0;
  for (int k = 0; k < kMostTurns; ++k) {
    const State towards = positions_of(covariance);
    const double variance = position_of(towards) + noise;
    gain = towards / variance;
    covariance = driven(covariance - towards * towards.transpose() / variance, by);
    if (std::abs(variance - before) < kSteady * variance) break;
    before = variance;
  }
  return gain;
}

/// The filtered state is x[k] = M x[k-1] + g (y[k] - h M x[k-1]), with the disturbance y, the
/// transition M of a step, the gain g, and h the sum of the positions. With v = (1 - M/z)^-1 g and
/// p = h M v / z, its transfer is v / (1 + p) (Sherman-Morrison formula). The correction is
/// h D x[k], with the transition D of the delay, and is shown after the delay.
std::vector<std::complex<double>> Predictor::transfer(std::span<const double> hz,
                                                      const LoopTiming& timing) const {
  const Transition by = transition(timing.step_s), ahead = transition(timing.delay_s);
  const State gain = steady_gain(by);
  std::vector<std::complex<double>> found;
  for (const double at : hz) {
    const auto one_step = delayed(at, timing.step_s);
    std::complex<double> expected = 0.0, predicted = 0.0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Eigen::Matrix2cd left = Eigen::Matrix2cd::Identity() - by[i] * one_step;
      const Eigen::Vector2cd state =
          left.inverse() * gain.segment<2>(2 * Eigen::Index(i)).cast<std::complex<double>>();
      expected += (by[i].row(0).cast<std::complex<double>>() * state)(0) * one_step;
      predicted += (ahead[i].row(0).cast<std::complex<double>>() * state)(0);
    }
    found.push_back(predicted * delayed(at, timing.delay_s) / (1.0 + expected));
  }
  return found;
}

}  // namespace ovws
