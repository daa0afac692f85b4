/// The measurement of a whole frame by templates of all its spots.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/realtime.hpp"
#include "core/spots/operating_point.hpp"
#include "core/spots/spot_fit.hpp"
#include "core/tracking/spot.hpp"

namespace ovws {

/// How well the templates describe a frame.
struct FittedFrame {
  bool credible = false;  ///< the templates describe this frame
  int used = 0;           ///< number of spots used: templates describe them
  int lost = 0;           ///< number of other spots that the reference has
  /// RMS residual of the estimates after the fit of the modes, in standard errors (by noise and
  /// higher modes).
  double residual = 0.0;
  double residual_px = 0.0;  ///< `residual` as a position error, camera pixels
  double drift_waves = 0.0;  ///< RMS change of all modes from the operating point
  double bent_waves = 0.0;   ///< error of all modes that the drift causes, RMS
  double brightness = 0.0;   ///< intensity over that at the operating point
};

/// Template fit of a whole frame; immutable after `check`. Templates are exact at the operating
/// point, the wavefront for which they were rendered. Coefficient errors grow with the square of
/// the distance from that point. RMS of all modes at 0.1 wave RMS from it (default bench): 0.01 for
/// 18 modes and 0.03 for 44; about twice as much about a wavefront of 1.2 wave.
class FrameFit {
 public:
  /// `rendered`: every spot at the operating point, with derivatives for `modes_j`.
  FrameFit(OperatingPoint point, std::span<const RenderedSpot> rendered, std::vector<int> modes_j);

  /// Working memory of one thread.
  struct Scratch {
    Eigen::VectorXd right, step, variances;
    Eigen::MatrixXd normal;
    std::vector<char> used;
  };

  const SpotFit& spots() const { return spots_; }
  const std::vector<int>& modes_j() const { return modes_j_; }
  const OperatingPoint& point() const { return point_; }
  Scratch make_scratch() const;

  /// Fits the image for which the templates were rendered. Credible only if the residual is not
  /// above noise or, with higher_waves = 0, below `max_residual_px`; and if at most an eighth of
  /// the spots is lost. Call it before any other thread uses this object.
  const FittedFrame& check(const ImageView& image, double max_residual_px);
  /// Measures the modes from all spots of one image; allocates memory.
  struct Measured {
    FittedFrame frame;
    std::vector<float> coefficients, sigma_waves;  ///< of modes_j, see `solve`
    std::vector<SpotFix> spots;
    std::vector<SpotEstimates> estimates;
  };
  Measured measure(const ImageView& image) const;
  /// Result of `check`. Templates rendered again about an equal wavefront leave an equal residual.
  const FittedFrame& at_point() const { return at_point_; }

  /// Least-squares fit of the modes to the estimates of the spots that the templates describe,
  /// without outliers. If these determine the modes, writes a coefficient and its standard error
  /// for each of modes_j, RMS-normalised waves, and each spot's fix, NaN for spots not used.
  /// Otherwise writes NaN for the modes, and `fixes` stays unchanged. Use the results only if
  /// credible. RT-safe.
  FittedFrame solve(std::span<const SpotEstimates> found, Scratch& scratch,
                    std::span<float> coefficients, std::span<float> sigma_waves,
                    std::span<SpotFix> fixes) const OVWS_NONBLOCKING;

 private:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using Values = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSpotEstimates, 1>;
  using Whitening = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxSpotEstimates,
                                  kMaxSpotEstimates>;
  bool in_air() const { return point_.higher_waves > 0.0; }
  void allow_for(std::span<const HigherErrors> higher);
  Values values_of(std::size_t spot, const SpotEstimates& found) const;
  bool describes(std::size_t spot, const SpotEstimates& found, double brightness) const;
  const Eigen::MatrixXd* covariance_by(Scratch& scratch) const;
  bool solve_normal(std::span<const SpotEstimates> found, Scratch& scratch) const;
  double select(std::span<const SpotEstimates> found, Scratch& scratch, FittedFrame& frame) const;
  double left_of(std::size_t spot, const SpotEstimates& found, const Scratch& scratch) const;
  double error_by_drift(const Scratch& scratch, double noise_waves) const;
  int summarise(std::span<const SpotEstimates> found, const Scratch& scratch, double brightness,
                FittedFrame& frame) const;

  OperatingPoint point_;
  std::vector<int> modes_j_;
  SpotFit spots_;
  std::vector<Rows> rows_;            ///< per spot: estimates x modes, scaled to errors of 1
  std::vector<Whitening> whitening_;  ///< per spot, for its estimates; empty: not needed
  Eigen::MatrixXd normal_, inverse_;
  Eigen::VectorXd growth_;  ///< factor on each mode's variance, by higher modes common to spots
  FittedFrame at_point_;
  double max_residual_px_ = 0.0;
  double px_error_ = 0.0;  ///< standard error of a position, RMS over the spots, camera px
};

}  // namespace ovws
