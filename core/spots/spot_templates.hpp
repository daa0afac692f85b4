/// The templates of one spot: linear estimators of the wavefront from its pixels.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

#include "core/spots/pixel_noise.hpp"
#include "core/spots/rendered_spot.hpp"

namespace ovws {

/// Templates of one spot. Near the rendering, its pixels are y = level * (light + per_wave * waves)
/// + background. Level and background are fitted to each spot. The derivatives, weighted by the
/// noise, are projected orthogonally to level and background, and weighted by the covariance of the
/// modes from all spots. The leading singular vectors of the product give the estimates: no other
/// set of equal size loses less of the modes' accuracy. The estimates are uncorrelated, with an
/// error of 1 for pixels of the assumed noise.
///
/// Estimates = level * per_wave * waves, waves counted from the rendering.
struct SpotTemplates {
  /// First rows of `rows`: orthonormal level and background, displacement. The estimates follow.
  enum Row { kLevel, kBackground, kX, kY, kFixed };

  SpotWindow window;
  Vec2 place_px;
  int lit = 0;                       ///< number of binned pixels that the laser reaches
  int used = 0;                      ///< number of them with a weight
  double brightest_intensity = 0.0;  ///< brightest of the used pixels, as rendered
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows;  ///< x padded cells
  Eigen::VectorXf weights;      ///< 1 / variance of each binned pixel, padded with 0
  Eigen::MatrixXd per_wave;     ///< estimates x modes
  Eigen::MatrixXd higher;       ///< estimates x N: for higher modes; empty: not known
  double intensity_norm = 0.0;  ///< the level part is level * intensity_norm + background * overlap
  double overlap = 0.0;
  double px_error =
      0.0;  ///< standard error of a position, RMS over x and y, times level of a binned pixel
  double even_norm = 0.0;  ///< the background part is background * even_norm

  int estimates() const { return int(per_wave.rows()); }
};

/// Errors of a spot's estimates if higher modes are present, times a binned pixel's level.
struct HigherErrors {
  Eigen::MatrixXd shared;  ///< estimates x N: by each higher mode, common to all spots
  double own = 1.0;        ///< variance by noise, and by the error of `shared`
  /// Whitening matrix: multiplied by it, the estimates are uncorrelated with errors of 1. Empty: no
  /// whitening is needed.
  Eigen::MatrixXd whitening;
};
/// Errors for higher modes of `higher_waves` RMS in total. `level_dn`: level of a binned pixel.
HigherErrors higher_errors(const SpotTemplates& spot, double level_dn, double higher_waves);

/// Brightness of a spot, DN of a binned pixel above the background.
struct CellLevel {
  double intensity_dn = 0.0;  ///< where the rendered intensity is 1
  /// Saturation ceiling: brighter binned pixels may be saturated and are not used.
  double ceiling_dn = std::numeric_limits<double>::infinity();
};

/// Makes the templates of all spots. `levels` and `noise` give the weights; a spot of level 0 has
/// equal weights and no effect on the others. `estimates`: number per spot, at most the number of
/// modes; 0 suffices for level, background and position. A spot without intensity, or with too few
/// binned pixels below the ceiling, gets no rows.
std::vector<SpotTemplates> make_templates(std::span<const RenderedSpot> spots,
                                          std::span<const CellLevel> levels,
                                          const PixelNoise& noise, int estimates);

}  // namespace ovws
