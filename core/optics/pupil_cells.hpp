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
/// of a square tile that lies in the pupil but in no subaperture.
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

/// A cell is the sum of its pixels without the carrier frequency of its piece, as seen from the
/// cell's centre. A wavefront changes slowly enough to act on whole cells. A cell on the border of
/// two pieces belongs to both, with the pixels of each.
struct PupilCells {
  int bin_px = 1;      ///< side of a cell, SLM pixels
  int first_x_px = 0;  ///< SLM pixel at which cell (0, 0) begins
  int first_y_px = 0;
  int width = 0, height = 0;  ///< cells
  Vec2 pupil_centre_px;       ///< centre of the SLM, the origin of pupil coordinates
  double pupil_radius_px = 0.0;
  std::vector<PupilPiece> pieces;  ///< the first are the lattice's subapertures in its order
  int subapertures = 0;
  std::vector<CellRun> runs;                 ///< sorted by piece
  std::vector<std::complex<float>> light;    ///< of the runs' cells
  Image<std::complex<float>> outside_pupil;  ///< the pixels where modes are not applied

  /// Centre of a cell, SLM pixels.
  Vec2 at_px(double x, double y) const {
    return {first_x_px + bin_px * x + 0.5 * (bin_px - 1),
            first_y_px + bin_px * y + 0.5 * (bin_px - 1)};
  }
  /// Position of an SLM pixel, cells.
  Vec2 at_cell(Vec2 px) const { return (1.0 / bin_px) * (px - at_px(0.0, 0.0)); }
};

/// `grey`: the hologram without any wavefront. Cells are as large as the far field in `window`
/// permits: at least 64 in the diameter of a subaperture.
PupilCells cut_pupil(const Lattice& lattice, double pupil_diameter_px, const FarFieldWindow& window,
                     const Image<std::uint8_t>& grey);

/// exp(2 pi i k / 65536).
const std::vector<std::complex<float>>& unit_phasors();

}  // namespace ovws
