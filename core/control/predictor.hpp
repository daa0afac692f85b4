/// Predictive control law: a Kalman filter for one mode's disturbance.
#pragma once

#include <Eigen/Core>
#include <array>

#include "core/control/disturbance.hpp"
#include "core/control/mode_law.hpp"

namespace ovws {

/// Predictor: estimates the disturbance (residual plus shown correction) with a Kalman filter
/// (Kalman, J. Basic Eng. 82, 35, 1960) and corrects what is expected at the time of showing.
/// Samples may come at any times, so that missing frames and a varying delay are allowed for. To
/// the identified oscillators it adds a slow drift, so that a constant disturbance is corrected
/// completely. A frame more than kJump standard errors off what was expected is skipped. If the
/// next one is off to the same side, it was a jump, and the drift follows at once.
class Predictor final : public ModeLaw {
 public:
  static constexpr double kJump = 6.0;

  explicit Predictor(const Disturbance& disturbance, double correction_waves);

  void observe(const ModeSample& sample) override;
  double step(std::int64_t t_ns, double limit_waves) override;
  /// Of the steady filter, which predicts over the delay.
  std::vector<std::complex<double>> transfer(std::span<const double> hz,
                                             const LoopTiming& timing) const override;

 private:
  static constexpr int kMaxStates = 2 * (Disturbance::kMaxParts + 1);
  using State = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxStates, 1>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxStates, kMaxStates>;

  /// Transition of the state: one block for each part.
  using Transition = std::array<Eigen::Matrix2d, Disturbance::kMaxParts + 1>;
  Transition transition(double seconds) const;
  State moved(const Transition& by, const State& state) const;
  /// Moves a covariance, with what drives the oscillators meanwhile.
  Square driven(Square covariance, const Transition& by) const;
  double position_of(const State& state) const;
  State positions_of(const Square& covariance) const;
  double noise_variance(double sigma_waves) const;
  /// Gain of the steady filter, with a sample every step whose transition is `by`.
  State steady_gain(const Transition& by) const;

  std::vector<Oscillator> parts_;  ///< the last one is the drift
  double noise_waves_;
  State stationary_;  ///< variances of the states
  State state_;       ///< at t_ns_
  Square covariance_;
  std::int64_t t_ns_ = 0;  ///< of the last sample; 0: none yet
  double skipped_ = 0.0;   ///< the last innovation, if its frame was skipped
  double first_waves_;     ///< the correction until the first sample
};

}  // namespace ovws
