/// Measured spots: mean images of the bench, with derivatives from pokes, without a model.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/zernike.hpp"
#include "core/spots/rendered_spot.hpp"

namespace ovws {

/// Binned pixels of all spots in a mean image: one column per spot, DN. NaN: a pixel was saturated,
/// or the spot is lost. Pixels that the laser does not reach are 0.
using SpotCells = Eigen::MatrixXf;
SpotCells cells_in(const Image<float>& mean_dn, std::span<const SpotWindow> windows);

/// Derivative of the lit binned pixels with respect to a displacement of the spot along x and y.
Eigen::MatrixXf change_by_shift(const Eigen::VectorXf& light, const SpotWindow& window);

/// Push-pull poke of a mode: binned pixels of the mean images with either sign.
struct PokedSpots {
  double amplitude_waves = 0.0;
  SpotCells plus, minus;
};

/// Makes the measured spots: `resting` without pokes, and one derivative for each of `pokes`. The
/// derivative with respect to a displacement is the intensity difference of neighbouring pixels.
/// Without pokes, the displacements along x and y count as modes. A spot has no intensity if a
/// pixel is saturated, if it is at the image's edge or beyond, or if it is too dim.
std::vector<RenderedSpot> measured_spots(std::span<const SpotWindow> windows,
                                         std::span<const Vec2> places_px, const SpotCells& resting,
                                         std::span<const PokedSpots> pokes);

/// Result of a calibration: measured spots and their derivatives.
struct MeasuredShapes {
  std::vector<int> modes_j;  ///< OSA indices of the modes of the derivatives
  std::vector<RenderedSpot> spots;
  std::vector<double> poke_waves{};  ///< amplitude for each of modes_j; empty: not known
  std::vector<Mode> fixed{};         ///< other modes that the SLM showed meanwhile

  const LitPixels& lit() const { return spots.front().window.lit; }
  /// Whether all windows lie in an image of this size.
  bool are_inside(int cols, int rows) const;
};

}  // namespace ovws
