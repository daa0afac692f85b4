/// An image averaged over square cells, without its background, and how noisy the cells are.
#pragma once

#include <Eigen/Core>

#include "core/base/image.hpp"
#include "core/base/vec2.hpp"

namespace ovws {

struct CellImage {
  int bin = 1;  ///< pixels of the lattice a side
  PixelLattice lattice{};
  Eigen::MatrixXf light;  ///< rows along y; DN above the median
  double noise = 1.0;     ///< RMS of a dark cell, DN: from the median deviation

  Vec2 to_cells(Vec2 px) const { return (1.0 / bin) * (lattice.from_image(px) - middle()); }
  Vec2 to_px(Vec2 cells) const { return lattice.to_image(double(bin) * cells + middle()); }

 private:
  Vec2 middle() const { return {0.5 * (bin - 1), 0.5 * (bin - 1)}; }  ///< of cell (0, 0)
};

/// Of cells of bin x bin pixels of the lattice. Whole cells only: up to bin - 1 pixels at the right
/// and the bottom are left out. Requires at least one cell. Allocates.
CellImage average_cells(const ImageView& image, const PixelLattice& lattice, int bin);

/// Whether the images differ in size, or by more than noise and 2 % of their contrast energy: spots
/// of lambda/d moved by some 0.06 lambda/d each.
bool is_other_image(const CellImage& before, const CellImage& now);

}  // namespace ovws
