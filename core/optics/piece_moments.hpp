/// One piece's own light near where it falls, and that of its field times each monomial: what any
/// smooth change of its phase does to the far field.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <span>
#include <vector>

#include "core/optics/sensor_field.hpp"

namespace ovws {

/// A box of camera pixels: columns [x, x + width), rows [y, y + height).
struct PixelBox {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// M_ab(u, v) = sum over the piece's pixels of A xi^a eta^b exp(-2 pi i (u x + v y)), where
/// (xi, eta) is the place from the piece's centre in units of its radius, and a + b <= kDegree.
///
/// Two small matrix products a box instead of a transform of the whole SLM: without its grating and
/// its mean slope the field is smooth, so pixels are summed in square blocks, and what a block
/// damps (the sinc of where the box looks) is divided out. Against FarField to 0.3 % of a spot's
/// peak within 4 lambda/d, some 2 ms a piece. One thread at a time.
class PieceMoments {
 public:
  static constexpr int kDegree = 3;
  static constexpr int kCount = (kDegree + 1) * (kDegree + 2) / 2;

  /// For the modes j of which modes_over speaks.
  PieceMoments(const SensorField& field, std::span<const int> modes_j);

  /// Takes these pieces (by number, rising) out of the field's pupil(), which `modes` made.
  void load(const SensorField& field, std::span<const Mode> modes, std::span<const int> pieces);
  /// Where a piece's light falls under these modes, camera pixels.
  Vec2 falls_px(std::size_t piece, std::span<const Mode> modes) const;

  /// The moments of a loaded piece in a box of the window, row-major pixels x kCount, by rising a,
  /// then b: column 0 is the piece's own far field. Valid until the next call.
  const Eigen::MatrixXcf& at(int piece, const PixelBox& box);

  /// Z x kCount: over the piece, mode j is the sum of coefficients times xi^a eta^b, least squares
  /// over its circle.
  const Eigen::MatrixXf& modes_over(int piece) const { return modes_[std::size_t(piece)]; }

 private:
  /// Sums over blocks: cell (q, p) begins at SLM pixel (x + p block, y + q block).
  struct Patch {
    int x = 0;
    int y = 0;
    int block = 1;
    Vec2 carrier_cpp;  ///< removed from the cells
    Eigen::MatrixXcf cells;
  };
  Vec2 slope_cpp(std::size_t piece, std::span<const Mode> modes) const;

  FarFieldWindow window_;
  Vec2 pupil_centre_px_;
  double pupil_radius_px_;
  std::vector<SensorField::Piece> pieces_;
  std::vector<Patch> patches_;
  std::vector<Eigen::MatrixXf> modes_;
  Eigen::MatrixXcf along_x_, along_y_, half_, moments_;
};

}  // namespace ovws
