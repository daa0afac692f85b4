/// The light on the SLM without any wavefront, summed in square cells of pixels.
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// A part of the pupil on which a wavefront is a low-order polynomial: a subaperture, or the part
/// of a square tile that lies in the pupil but in no subaperture. Along the camera's axes, as all
/// of PupilCells.
struct PupilPiece {
  Vec2 centre_px;    ///< from the pupil's centre
  double radius_px;  ///< to its farthest pixel
  Vec2 grating_cpp;  ///< 0 outside the subapertures
};

/// The cells of one piece in one row of cells: columns [begin, end).
struct CellRun {
  int piece = 0;
  int y = 0;
  int begin = 0;
  int end = 0;
  std::size_t first = 0;  ///< of the values of the cells: that of column `begin`
};

/// Square cells about the pupil's centre.
struct CellGrid {
  int bin_px = 1;  ///< side of a cell, SLM pixels
  int width = 0, height = 0;

  Vec2 middle() const { return {0.5 * (width - 1), 0.5 * (height - 1)}; }
  /// Centre of a cell, SLM pixels from the pupil's centre.
  Vec2 at_px(double x, double y) const { return bin_px * (Vec2{x, y} - middle()); }
  /// The inverse: cell coordinates, whole numbers at the cells' centres.
  Vec2 at_cell(Vec2 px) const { return (1.0 / bin_px) * px + middle(); }
};

/// The cells are aligned with the camera, which may be turned or mirrored (PxPerCycle::seen), so
/// that its rows and columns of pixels are those of the far field.
///
/// A cell is the sum of its pixels without the carrier frequency of its piece, as seen from the
/// cell's centre. A wavefront changes slowly enough to act on whole cells. A cell on the border of
/// two pieces belongs to both, with the pixels of each.
struct PupilCells {
  CellGrid grid;    ///< over the pupil
  PxPerCycle turn;  ///< of the camera; its scale does not count
  double pupil_radius_px = 0.0;
  std::vector<PupilPiece> pieces;  ///< the first are the lattice's subapertures in its order
  int subapertures = 0;
  std::vector<CellRun> runs;               ///< sorted by piece
  std::vector<std::complex<float>> light;  ///< of the runs' cells
  CellGrid outside_grid;                   ///< over the SLM
  Image<std::complex<float>> outside;      ///< light outside the pupil, where no mode is applied

  /// A position in pupil radii, as the modes count it.
  Vec2 in_pupil(Vec2 at_px) const { return (1.0 / pupil_radius_px) * turn.back(at_px); }
};

/// `grey`: the hologram without any wavefront. Cells are as large as the far field in `window`
/// permits: at least 64 in the diameter of a subaperture, if that has as many pixels. `window` is
/// along the camera's axes.
PupilCells cut_pupil(const Lattice& lattice, double pupil_diameter_px, const PxPerCycle& turn,
                     const FarFieldWindow& window, const Image<std::uint8_t>& grey);

}  // namespace ovws
