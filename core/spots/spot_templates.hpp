/// The templates of one spot: linear estimators of the wavefront from its pixels.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

#include "core/spots/pixel_noise.hpp"
#include "core/spots/rendered_spot.hpp"

namespace ovws {

/// The pixels y of a spot near its rendering are level * (light + per_wave * waves) + background.
/// Level and background are fitted to each spot. The derivatives, weighted by the noise, are
/// projected orthogonally to level and background, and weighted by the covariance of the modes from
/// all spots. The leading singular vectors of the product are the estimates: no other set of as
/// many loses less of the modes' accuracy. They are uncorrelated, and have an error of 1 in pixels
/// of the assumed noise.
///
/// Estimates = level * per_wave * waves, waves counted from the rendering.
struct SpotTemplates {
  /// Rows of `rows` before the estimates: orthonormal parts of level and background, displacement.
  enum Row { kLevel, kBackground, kX, kY, kFixed };

  SpotWindow window;
  Vec2 place_px;
  int used = 0;                      ///< cells with a weight
  double brightest_intensity = 0.0;  ///< of these, as rendered
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows;  ///< x padded cells
  Eigen::VectorXf weights;      ///< 1 / variance of each cell, padded with 0
  Eigen::MatrixXd per_wave;     ///< estimates x Z
  Eigen::MatrixXd higher;       ///< estimates x N: the same for higher modes; empty: not known
  double intensity_norm = 0.0;  ///< the level part is level * intensity_norm + background * overlap
  double overlap = 0.0;
  double px_error =
      0.0;  ///< standard error of a position, RMS over x and y, times the cells' level
  double even_norm = 0.0;  ///< the background part is background * even_norm

  int estimates() const { return int(per_wave.rows()); }
};

/// Errors of a spot's estimates, times the cells' level, where higher modes are.
struct HigherErrors {
  Eigen::MatrixXd shared;  ///< estimates x N: by each higher mode, which changes all spots at once
  double own = 1.0;        ///< variance by noise, and by what `shared` is wrong
  /// Estimates x estimates. Times it, the estimates have errors of 1 and are uncorrelated. Empty:
  /// they are so already.
  Eigen::MatrixXd whitening;
};
/// For higher modes of `higher_waves` RMS together. `level_dn`: of a cell.
HigherErrors higher_errors(const SpotTemplates& spot, double level_dn, double higher_waves);

/// How bright a spot is, DN of a cell above the background.
struct CellLevel {
  double intensity_dn = 0.0;  ///< where the rendered intensity is 1
  /// Brighter cells may hold saturated pixels and are not used.
  double ceiling_dn = std::numeric_limits<double>::infinity();
};

/// Of all spots together. `levels` and `noise` give the weights; a spot of level 0 is not used.
/// `estimates`: of each spot, at least 1, at most the number of modes. A spot without light, or
/// with too few cells below the ceiling, gets no rows.
std::vector<SpotTemplates> make_templates(std::span<const RenderedSpot> spots,
                                          std::span<const CellLevel> levels,
                                          const PixelNoise& noise, int estimates);

}  // namespace ovws
