/// The expected image of one spot for a given wavefront, and its derivatives.
#pragma once

#include <Eigen/Core>

#include "core/base/vec2.hpp"
#include "core/optics/piece_moments.hpp"

namespace ovws {

/// A square of cells around a spot. A cell is the sum of bin x bin camera pixels.
struct SpotWindow {
  int left = 0;  ///< first camera pixel
  int top = 0;
  int side = 0;  ///< cells along each axis
  int bin = 1;   ///< camera pixels of a cell along each axis

  int cells() const { return side * side; }
  PixelBox pixels() const { return {left, top, side * bin, side * bin}; }

  friend bool operator==(const SpotWindow&, const SpotWindow&) = default;
};

/// A window for spots of this size, without its place. Cells are of 2 x 2 pixels where that loses
/// nothing, from lambda/d of 10 pixels on. `half_width` in units of lambda/d.
SpotWindow window_of(double lambda_d_px, double half_width);
/// Half the width of windows for j = 1 to `modes`, units of lambda/d: 2.0, or 2.3 for more modes
/// than positions determine, which change the intensity farther out.
double window_half_width(int modes, int subapertures_across);
/// The same window around `place_px`, inside an image of at least its size.
SpotWindow moved_to(Vec2 place_px, SpotWindow window, int cols, int rows);

/// Cells are row-major. A spot at the image's edge or beyond has no light. Light is relative: the
/// brightest cell of all spots for a flat wavefront is 1.
struct RenderedSpot {
  SpotWindow window;
  Vec2 place_px;             ///< where the mean slope puts the spot's centre
  Eigen::VectorXf light;     ///< of each cell
  Eigen::MatrixXf per_wave;  ///< cells x Z: derivative with respect to each mode
  Eigen::MatrixXf per_px;    ///< cells x 2: derivative with respect to its displacement in x and y
  /// Cells x kCount: derivative with respect to each monomial of the phase over its own subaperture
  /// (PieceMoments), in waves; empty: not known.
  Eigen::MatrixXf per_monomial;
  Eigen::MatrixXf higher;    ///< N x kCount: the higher modes (PieceMoments)
  double higher_rest = 0.0;  ///< what these leave of them, waves^2
};

/// Whether the spot is well inside its window, which stays inside the image.
bool is_inside(const RenderedSpot& spot);
/// The level of the dark cells around a spot.
double dark_level(Eigen::VectorXf cells);

}  // namespace ovws
