/// Spots as mean images of the bench show them, with derivatives that pokes measure: no model.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/spots/rendered_spot.hpp"

namespace ovws {

/// What a mean image shows of the spots: cells x spots, DN of a cell. NaN: a pixel was saturated.
using SpotCells = Eigen::MatrixXf;
SpotCells cells_in(const Image<float>& mean_dn, std::span<const SpotWindow> windows);

/// Derivative of the cells with respect to a displacement along x and y: the intensity gradient.
Eigen::MatrixXf change_by_shift(const Eigen::VectorXf& light, const SpotWindow& window);

/// Mean images of a mode with either sign.
struct PokedSpots {
  double amplitude_waves = 0.0;
  SpotCells plus, minus;
};

/// The spots at rest, with their measured derivatives, one for each of `pokes`. The derivative with
/// respect to a displacement is the intensity gradient. Without pokes, these two displacements
/// count as modes. A spot has no light if a pixel is saturated, if it is at the image's edge or
/// beyond, or if there is almost none.
std::vector<RenderedSpot> measured_spots(std::span<const SpotWindow> windows,
                                         std::span<const Vec2> places_px, const SpotCells& resting,
                                         std::span<const PokedSpots> pokes);

/// What a calibration measured.
struct MeasuredShapes {
  std::vector<int> modes_j;  ///< of the derivatives
  std::vector<RenderedSpot> spots;

  /// Whether all windows lie in an image of this size.
  bool are_inside(int cols, int rows) const;
};

}  // namespace ovws
