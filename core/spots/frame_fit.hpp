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
  int used = 0;           ///< spots that they describe
  int lost = 0;           ///< other spots that the reference has
  /// RMS of what the modes leave of the estimates, in standard errors by noise and higher modes.
  double residual = 0.0;
  double residual_px = 0.0;  ///< the same in standard errors of a position
  double drift_waves = 0.0;  ///< RMS change of all modes since the rendering
};

/// Immutable once checked. Templates are exact at the wavefront that they were rendered for, the
/// operating point. The error of the coefficients grows with the square of the distance: 0.0005
/// wave at 0.02 wave RMS, 0.003 at 0.05 and 0.01 to 0.02 at 0.1 (default bench, 18 modes).
class FrameFit {
 public:
  /// `rendered`: every spot at the point, with derivatives for `modes_j`.
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

  /// Fits the image that the templates were rendered for. It is credible only if the modes leave no
  /// more than noise of the estimates, or, unless higher modes are allowed for, less than
  /// `max_residual_px`. Call before any other thread uses this object.
  const FittedFrame& check(const ImageView& image, double max_residual_px);
  /// The modes from all spots of one image; allocates.
  struct Measured {
    FittedFrame frame;
    std::vector<float> coefficients, sigma_waves;  ///< of modes_j, see `solve`
    std::vector<SpotFix> spots;
    std::vector<SpotEstimates> estimates;
  };
  Measured measure(const ImageView& image) const;
  /// What `check` found; templates made again about the same wavefront leave as much.
  const FittedFrame& at_point() const { return at_point_; }

  /// Least squares over the estimates of the spots that the templates describe, and that the others
  /// do not contradict. If the frame is credible, writes a coefficient and its standard error for
  /// each of modes_j, RMS-normalised waves, and the position of each spot; NaN for those not used.
  /// RT-safe.
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
  int summarise(std::span<const SpotEstimates> found, const Scratch& scratch, double brightness,
                FittedFrame& frame) const;

  OperatingPoint point_;
  std::vector<int> modes_j_;
  SpotFit spots_;
  std::vector<Rows> rows_;            ///< per spot: estimates x Z, unit errors
  std::vector<Whitening> whitening_;  ///< of each spot's estimates; empty: none
  Eigen::MatrixXd normal_, inverse_;
  Eigen::VectorXd growth_;  ///< of each mode's variance, because higher modes change all spots
  FittedFrame at_point_;
  double max_residual_px_ = 0.0;
  double px_error_ = 0.0;  ///< of a position, RMS over the spots, camera pixels
};

}  // namespace ovws
