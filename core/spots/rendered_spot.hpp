/// The expected image of one spot for a given wavefront, and its derivatives.
#pragma once

#include <Eigen/Core>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"
#include "core/optics/piece_moments.hpp"

namespace ovws {

/// Pixel window around a spot: a square of binned pixels ("cells"), each the sum of bin x bin
/// camera pixels. Of a colour camera bin is 1. Where one colour plane sees the laser, the cells are
/// the pixels of that plane. A green laser is seen by two of them: then the cells are all pixels,
/// of which every second is lit.
struct SpotWindow {
  int left = 0;  ///< first camera pixel
  int top = 0;
  int side = 0;     ///< binned pixels along each axis
  int bin = 1;      ///< camera pixels of a binned pixel, along each axis
  LitPixels lit{};  ///< camera pixels that the laser reaches

  int cells() const { return side * side; }
  /// Camera pixels between neighbouring pixels of the cells.
  int plane_step() const { return lit.diagonal ? 1 : lit.plane.step; }
  /// Cells between neighbouring cells of one colour.
  int colour_step() const { return lit.diagonal ? lit.plane.step : 1; }
  /// Camera pixels between neighbouring cells, along each axis.
  int pitch() const { return bin * plane_step(); }
  int width_px() const { return side * pitch(); }
  /// Whether the laser reaches binned pixel `cell`.
  bool is_lit(Eigen::Index cell) const {
    return !lit.diagonal || lit.has(left + int(cell) % side, top + int(cell) / side);
  }
  /// Box from the first to the last camera pixel of the cells. On a colour plane it is a pixel
  /// narrower than width_px(): the last cell is one pixel, not a pitch.
  PixelBox pixels() const {
    const int width = width_px() - pitch() + bin;
    return {left, top, width, width};
  }

  friend bool operator==(const SpotWindow&, const SpotWindow&) = default;
};

/// Window size for spots of size lambda/d; the position stays unset. Bins 2 x 2 pixels if lambda/d
/// is at least 10 pixels, which loses no information, and if the laser reaches all pixels.
/// `half_width` in units of lambda/d.
SpotWindow window_of(double lambda_d_px, double half_width, const LitPixels& lit = {});
/// Half the width of windows for j = 1 to `modes`, units of lambda/d: 2.0, or 2.6 for more modes
/// than positions determine, because higher modes change the intensity farther out. The error of 44
/// modes at 0.3 wave RMS and SNR 22 is 1.33 of the bound of all pixels with 2.0, 1.24 with 2.6.
double window_half_width(int modes, int subapertures_across);
/// Returns the window with its centre at `place_px`, or as near as the image's edges allow. The
/// image must be at least as large as the window.
SpotWindow moved_to(Vec2 place_px, SpotWindow window, int cols, int rows);

/// The colour plane that the cells of `window` are on, or the whole image. RT-safe.
inline ImageView seen_by(const SpotWindow& window, const ImageView& image) {
  return window.plane_step() > 1 ? on_plane(image, window.lit.plane) : image;
}
/// Calls `visit(cell, x, y)` for every camera pixel (x, y) of every binned pixel.
void each_pixel(const SpotWindow& window, auto&& visit) {
  for (int cell = 0; cell < window.cells(); ++cell) {
    const int x = window.left + cell % window.side * window.pitch();
    const int y = window.top + cell / window.side * window.pitch();
    for (int k = 0; k < window.bin * window.bin; ++k) {
      visit(Eigen::Index(cell), x + k % window.bin, y + k / window.bin);
    }
  }
}

/// Rendered spot; its binned pixels are row-major. Intensity is relative: the brightest binned
/// pixel of all spots for a flat wavefront is 1. A spot at the image's edge or beyond has intensity
/// 0.
struct RenderedSpot {
  SpotWindow window;
  Vec2 place_px;             ///< where the mean slope puts the spot's centre
  Eigen::VectorXf light;     ///< relative intensity of each binned pixel
  Eigen::MatrixXf per_wave;  ///< binned pixels x modes: derivative with respect to each mode
  Eigen::MatrixXf per_px;    ///< binned pixels x 2: derivative with respect to displacement in x, y
  /// Binned pixels x kCount: derivative with respect to each monomial of the phase over the spot's
  /// own subaperture (PieceMoments), in waves; empty: not known.
  Eigen::MatrixXf per_monomial;
  Eigen::MatrixXf higher;    ///< N x kCount: the higher modes (PieceMoments)
  double higher_rest = 0.0;  ///< residual variance after the fit by `higher`, waves^2
};

/// Whether the spot is well inside its window, which stays inside the image.
bool is_inside(const RenderedSpot& spot);
/// Dark level around a spot: a tenth of its lit binned pixels is darker.
double dark_level(const Eigen::VectorXf& cells, const SpotWindow& window);

}  // namespace ovws
