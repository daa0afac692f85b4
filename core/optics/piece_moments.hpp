/// Far-field moments of one pupil piece: its far field and that of its field times each monomial.
/// They give the derivative of the far field with respect to any smooth phase change.
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

/// Points of the far field: (first_px + step_px * (column, row)), camera pixels.
struct FarPoints {
  Vec2 first_px;
  int width = 0;
  int height = 0;
  double step_px = 1.0;

  FarPoints(Vec2 first, int columns, int rows, double step)
      : first_px(first), width(columns), height(rows), step_px(step) {}
  /// The pixels of a box.
  FarPoints(const PixelBox& box)  // NOLINT(google-explicit-constructor)
      : first_px{double(box.x), double(box.y)}, width(box.width), height(box.height) {}
};

/// M_ab(u, v) = sum over the piece's cells of A xi^a eta^b exp(-2 pi i (u x + v y)), where
/// (xi, eta) is the position from the piece's centre in units of its radius, and a + b <= kDegree.
///
/// Costs two small matrix products per box instead of a transform of the whole SLM. Without its
/// grating and mean slope the field is smooth, so cells are summed in square blocks; the
/// attenuation by a block (a Dirichlet kernel) is divided out. Agrees with FarField to 0.3 % of a
/// spot's peak within 4 lambda/d, in some 2 ms per piece. One thread at a time.
class PieceMoments {
 public:
  static constexpr int kDegree = 3;
  static constexpr int kCount = (kDegree + 1) * (kDegree + 2) / 2;

  /// `modes_j`: the modes of modes_over.
  PieceMoments(const SensorField& field, std::span<const int> modes_j);

  /// Loads these pieces (ascending numbers) from field.pupil(), which was propagated with `modes`.
  void load(const SensorField& field, std::span<const Mode> modes, std::span<const int> pieces);
  /// Position of a piece's spot with these modes, camera pixels.
  Vec2 falls_px(std::size_t piece, std::span<const Mode> modes) const;

  /// Moments of a loaded piece: row-major points x kCount, columns by rising a, then b. Column 0 is
  /// the piece's far field. Valid until the next call.
  const Eigen::MatrixXcf& at(int piece, const FarPoints& points);

  /// Z x kCount: coefficients of each mode as a polynomial in xi^a eta^b over the piece, by a
  /// least-squares fit over its circle.
  const Eigen::MatrixXf& modes_over(int piece) const { return modes_[std::size_t(piece)]; }
  /// N x kCount: the same over a subaperture of each of higher_modes, times its standard deviation.
  const Eigen::MatrixXf& higher_over(int piece) const { return higher_[std::size_t(piece)]; }
  /// Variance of what these polynomials leave of the higher modes, waves^2.
  double higher_rest(int piece) const { return rests_[std::size_t(piece)]; }

 private:
  /// Sums over blocks of cells: block (q, p) begins at the cell (x + p block, y + q block).
  struct Patch {
    int x = 0;
    int y = 0;
    int block = 1;
    Vec2 carrier_cpp;  ///< carrier frequency, demodulated in the blocks
    Eigen::MatrixXcf blocks;
  };
  Vec2 slope_cpp(std::size_t piece, std::span<const Mode> modes) const;

  FarFieldWindow window_;
  double pupil_radius_px_;
  PxPerCycle turn_;
  CellGrid grid_;
  std::vector<PupilPiece> pieces_;
  std::vector<Patch> patches_;
  std::vector<Eigen::MatrixXf> modes_, higher_;
  std::vector<double> rests_;
  Eigen::MatrixXcf along_x_, along_y_, half_, moments_;
};

}  // namespace ovws
