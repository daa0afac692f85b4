/// Far-field moments of one pupil piece: far fields of the piece's field times each monomial of the
/// position. They give the derivative of the far field with respect to any smooth phase change.
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

/// Grid of far-field points at first_px + step_px * (column, row), camera pixels.
struct FarPoints {
  Vec2 first_px;
  int width = 0;
  int height = 0;
  double step_px = 1.0;

  FarPoints(Vec2 first, int columns, int rows, double step)
      : first_px(first), width(columns), height(rows), step_px(step) {}
  /// Grid of all pixels of a box.
  FarPoints(const PixelBox& box)  // NOLINT(google-explicit-constructor)
      : first_px{double(box.x), double(box.y)}, width(box.width), height(box.height) {}
};

/// Moments M_ab(u, v) = sum over the piece's cells of A xi^a eta^b exp(-2 pi i (u x + v y)). (xi,
/// eta) is the position from the piece's centre in units of the piece's radius; a + b <= kDegree.
///
/// Costs two small matrix products per box instead of a transform of the whole SLM. Without grating
/// and mean slope a piece's field is smooth, so cells are summed in square blocks. The attenuation
/// by a block (a Dirichlet kernel) is divided out. Agrees with FarField to 0.3 % of a spot's peak
/// within 4 lambda/d. Takes some 0.05 ms per box. For one thread at a time.
class PieceMoments {
 public:
  static constexpr int kDegree = 3;
  static constexpr int kCount = (kDegree + 1) * (kDegree + 2) / 2;
  static constexpr Eigen::Index kAlongX = kDegree + 1, kAlongY = 1;  ///< indices of xi and eta

  /// `modes_j`: OSA indices of the modes that modes_over() expands.
  PieceMoments(const SensorField& field, std::span<const int> modes_j);

  /// Loads `pieces` (ascending numbers) from field.pupil(). Call field.propagate(modes, …) before,
  /// with equal modes.
  void load(const SensorField& field, std::span<const Mode> modes, std::span<const int> pieces);
  /// Position of a piece's spot on the camera if the wavefront is `modes`, camera pixels.
  Vec2 falls_px(std::size_t piece, std::span<const Mode> modes) const;

  /// Moments M_ab of a loaded piece. Rows: the points, row-major. Columns: kCount moments by rising
  /// a, then b; column 0 is the piece's far field. `points` has at least kMinProductRows columns.
  /// The reference is valid until the next call.
  const Eigen::MatrixXcf& at(int piece, const FarPoints& points);

  /// Modes as polynomials over a piece, by least squares. Row: one of modes_j, 1 wave. Columns:
  /// kCount coefficients of xi^a eta^b.
  const Eigen::MatrixXf& modes_over(int piece) const { return modes_[std::size_t(piece)]; }
  /// Polynomials, as in modes_over(), of the modes of higher_modes() (kolmogorov.hpp), each times
  /// its standard deviation in turbulence. `piece` must be a subaperture.
  const Eigen::MatrixXf& higher_over(int piece) const { return higher_[std::size_t(piece)]; }
  /// Residual variance of the higher modes after the fit by higher_over()'s polynomials, waves^2.
  double higher_rest(int piece) const { return rests_[std::size_t(piece)]; }

 private:
  /// Field of a piece, summed over square blocks of cells. Block (row q, column p) begins at the
  /// cell (x + p block, y + q block).
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
