/// Complex field on the SLM for a flat wavefront, summed in square cells of SLM pixels.
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

#include "core/base/image.hpp"
#include "core/optics/far_field.hpp"
#include "core/optics/geometry.hpp"
#include "core/optics/lattice.hpp"

namespace ovws {

/// Piece of the pupil, small enough that a wavefront on it is a low-order polynomial: a
/// subaperture, or the part of a square tile that lies in the pupil but in no subaperture.
/// Coordinates are along the camera's axes.
struct PupilPiece {
  Vec2 centre_px;    ///< SLM pixels from the pupil's centre
  double radius_px;  ///< distance from the centre to the farthest point, SLM pixels
  Vec2 grating_cpp;  ///< grating frequency, cycles per SLM pixel; 0 for tiles
};

/// Run of cells: the cells of one piece in row y of the grid, columns [begin, end).
struct CellRun {
  int piece = 0;
  int y = 0;
  int begin = 0;
  int end = 0;
  std::size_t first = 0;  ///< index of column `begin` in PupilCells::light
};

/// Grid of square cells, centred on the pupil's centre.
struct CellGrid {
  double bin_px = 1.0;  ///< side of a cell, SLM pixels
  int width = 0, height = 0;

  Vec2 middle() const { return {0.5 * (width - 1), 0.5 * (height - 1)}; }
  /// Centre of a cell, SLM pixels from the pupil's centre.
  Vec2 at_px(double x, double y) const { return bin_px * (Vec2{x, y} - middle()); }
  /// Cell coordinates of a position in SLM pixels (inverse of at_px); integers at cell centres.
  Vec2 at_cell(Vec2 px) const { return (1.0 / bin_px) * px + middle(); }
};

/// Field of the pupil in cells, which are aligned with the camera's axes (PxPerCycle::seen). The
/// camera may be rotated or mirrored; its pixel rows and columns are those of the far field.
///
/// The value of a cell is the sum of its pixels' field after removing its piece's carrier frequency
/// about the cell's centre. A wavefront changes slowly enough to act on whole cells. A cell on the
/// border of two pieces occurs in both, each time with only the pixels of that piece.
struct PupilCells {
  CellGrid grid;    ///< cells that cover the pupil
  PxPerCycle turn;  ///< rotation or mirroring by the camera; its scale is ignored
  double pupil_radius_px = 0.0;
  std::vector<PupilPiece> pieces;  ///< first the subapertures, in the lattice's order
  int subapertures = 0;
  std::vector<CellRun> runs;               ///< sorted by piece
  std::vector<std::complex<float>> light;  ///< field in the cells of `runs`
  CellGrid outside_grid;                   ///< cells that cover the whole SLM
  Image<std::complex<float>> outside;      ///< field outside the pupil, where no mode is applied

  /// Converts a position (SLM pixels, camera's axes) to pupil radii along the SLM's axes.
  Vec2 in_pupil(Vec2 at_px) const { return (1.0 / pupil_radius_px) * turn.back(at_px); }
};

/// Cuts the pupil into pieces and cells. `grey`: hologram of a flat wavefront. `window`: far-field
/// window along the camera's axes. Cells are as large as the window permits, at most 4 SLM pixels,
/// with at least 64 cells across a subaperture of 64 or more pixels.
PupilCells cut_pupil(const Lattice& lattice, double pupil_diameter_px, const PxPerCycle& turn,
                     const FarFieldWindow& window, const Image<std::uint8_t>& grey);

}  // namespace ovws
