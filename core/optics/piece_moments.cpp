#include "core/optics/piece_moments.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/base/complex_product.hpp"
#include "core/base/decompositions.hpp"
#include "core/optics/complex_matrices.hpp"
#include "core/optics/kolmogorov.hpp"

namespace ovws {
namespace {

constexpr int kBlocksAcross = 36;  // approximate; over 2 blocks per cycle in a box of 8 lambda/d
constexpr int kFitAcross = 24;     // samples across the circle for the polynomial fit of the modes
constexpr int kHigherAcross = 12;  // for higher modes, where an error of 0.1 of a mode is harmless

/// Attenuation of a frequency by summing blocks (Dirichlet kernel): mean of exp(2 pi i f k) over
/// `block` samples about the block's centre. `cycles`: f, cycles per sample.
double damping(double cycles, int block) {
  const double x = std::numbers::pi * cycles;
  return std::abs(x) < 1e-9 ? 1.0 : std::sin(x * block) / (block * std::sin(x));
}

/// Frequencies of the far-field points along one axis, and size of a patch's blocks.
struct FrequencyLine {
  double first_cpp = 0.0;  ///< first frequency, relative to the carrier
  double step_cpp = 0.0;
  int count = 0;
  double cell_px = 1.0;
  int block = 1;  ///< cells along the side of a block
};

/// Fourier kernel with moments: fills [W; t W; t^2 W; ...], line.count rows each. W(k, p) =
/// exp(-2 pi i f_k x_p) / damping(f_k). t: position from the centre in units of the radius.
void fill_kernel(const FrequencyLine& line, const Eigen::VectorXd& x_px, double centre_px,
                 double radius_px, Eigen::MatrixXcf& out) {
  constexpr int kPowers = PieceMoments::kDegree + 1;
  const Eigen::Index rows = line.count;
  out.resize(kPowers * rows, x_px.size());
  for (Eigen::Index p = 0; p < x_px.size(); ++p) {
    std::complex<double> w = unit_phasor(-line.first_cpp * x_px(p));
    const std::complex<double> next = unit_phasor(-line.step_cpp * x_px(p));
    for (int k = 0; k < line.count; ++k, w = product(w, next)) out(k, p) = std::complex<float>(w);
  }
  for (int k = 0; k < line.count; ++k) {
    const double f = line.first_cpp + k * line.step_cpp;
    out.row(k) *= float(1.0 / damping(f * line.cell_px, line.block));
  }
  const Eigen::VectorXcf place =
      ((x_px.array() - centre_px) / radius_px).cast<float>().cast<std::complex<float>>();
  for (int a = 1; a < kPowers; ++a) {
    out.middleRows(a * rows, rows) = out.middleRows((a - 1) * rows, rows) * place.asDiagonal();
  }
}

/// Least-squares fit of Zernike modes by polynomials over the circle around a pupil piece.
class PolynomialFit {
 public:
  /// `across`: number of samples across the circle's diameter.
  PolynomialFit(std::vector<Mode> modes, int across) : modes_(std::move(modes)) {
    for (int k = 0; k < across * across; ++k) {
      const Vec2 at{(2 * (k / across) + 1.0) / across - 1.0,
                    (2 * (k % across) + 1.0) / across - 1.0};
      if (norm(at) <= 1.0) places_.push_back(at);
    }
    basis_.resize(Eigen::Index(places_.size()), PieceMoments::kCount);
    for (std::size_t p = 0; p < places_.size(); ++p) {
      Eigen::Index k = 0;
      for (int a = 0; a <= PieceMoments::kDegree; ++a) {
        for (int b = 0; a + b <= PieceMoments::kDegree; ++b) {
          basis_(Eigen::Index(p), k++) = std::pow(places_[p].x, a) * std::pow(places_[p].y, b);
        }
      }
    }
    const Eigen::Index count = basis_.rows();
    fit_ = least_squares(basis_, Eigen::MatrixXd(Eigen::MatrixXd::Identity(count, count)));
  }

  struct Over {
    Eigen::MatrixXf polynomials;  ///< one row per mode, kCount coefficients
    double rest;                  ///< variance of the fit's residual
  };
  Over over(const PupilCells& cells, const PupilPiece& piece) const {
    Eigen::MatrixXd values(places_.size(), modes_.size());
    int last_j = 0;
    for (const Mode& mode : modes_) last_j = std::max(last_j, mode.j);
    std::vector<double> all(std::size_t(last_j) + 1);
    for (std::size_t p = 0; p < places_.size(); ++p) {
      zernike_values(cells.in_pupil(piece.centre_px + piece.radius_px * places_[p]), all);
      for (std::size_t k = 0; k < modes_.size(); ++k) {
        values(p, k) = modes_[k].waves * all[std::size_t(modes_[k].j)];
      }
    }
    const Eigen::MatrixXd solved = fit_ * values;
    return {solved.transpose().cast<float>(),
            (values - basis_ * solved).squaredNorm() / double(places_.size())};
  }

 private:
  std::vector<Mode> modes_;
  std::vector<Vec2> places_;
  Eigen::MatrixXd basis_;
  Eigen::MatrixXd fit_;  ///< pseudo-inverse of basis_
};

}  // namespace

PieceMoments::PieceMoments(const SensorField& field, std::span<const int> modes_j)
    : window_(field.window()),
      pupil_radius_px_(field.cells().pupil_radius_px),
      turn_(field.cells().turn / field.cells().turn.scale()),
      grid_(field.cells().grid),
      pieces_(field.cells().pieces),
      patches_(pieces_.size()) {
  std::vector<Mode> one_wave;
  for (const int j : modes_j) one_wave.push_back({j, 1.0});
  const PolynomialFit modes(std::move(one_wave), kFitAcross);
  const PolynomialFit higher(higher_modes(modes_j), kHigherAcross);
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const PupilPiece& piece = pieces_[i];
    const Vec2 corner{piece.centre_px.x - piece.radius_px, piece.centre_px.y - piece.radius_px};
    const Vec2 first = grid_.at_cell(corner);
    const double across = 2.0 * piece.radius_px / grid_.bin_px;
    patches_[i].x = int(std::floor(first.x)) - 2;
    patches_[i].y = int(std::floor(first.y)) - 2;
    patches_[i].block = std::max(1, int(std::lround(across / kBlocksAcross)));
    modes_.push_back(modes.over(field.cells(), piece).polynomials);
    if (int(i) >= field.subapertures()) continue;
    auto above = higher.over(field.cells(), piece);
    higher_.push_back(std::move(above.polynomials));
    rests_.push_back(above.rest);
  }
}

Vec2 PieceMoments::slope_cpp(std::size_t piece, std::span<const Mode> modes) const {
  const Vec2 at = (1.0 / pupil_radius_px_) * turn_.back(pieces_[piece].centre_px);
  const Vec2 gradient = turn_ * wavefront_gradient(modes, at);
  return pieces_[piece].grating_cpp + (1.0 / pupil_radius_px_) * gradient;
}

Vec2 PieceMoments::falls_px(std::size_t piece, std::span<const Mode> modes) const {
  return (1.0 / window_.step_cpp) * (slope_cpp(piece, modes) - window_.origin_cpp);
}

void PieceMoments::load(const SensorField& field, std::span<const Mode> modes,
                        std::span<const int> pieces) {
  const std::vector<CellRun>& runs = field.cells().runs;
  for (const int piece : pieces) {
    Patch& patch = patches_[piece];
    const int side = int(2.0 * pieces_[piece].radius_px / grid_.bin_px + 6.0) / patch.block + 1;
    patch.blocks.setZero(side, side);
    patch.carrier_cpp = slope_cpp(std::size_t(piece), modes);
    const Vec2 f = grid_.bin_px * patch.carrier_cpp;
    const std::complex<double> next = unit_phasor(-f.x);
    const Vec2 middle = grid_.middle();
    auto run = std::lower_bound(runs.begin(), runs.end(), piece,
                                [](const CellRun& r, int p) { return r.piece < p; });
    for (; run != runs.end() && run->piece == piece; ++run) {
      std::complex<double> back =
          unit_phasor(-f.x * (run->begin - middle.x) - f.y * (run->y - middle.y));
      const std::complex<float>* value = field.pupil().data() + run->first;
      auto blocks = patch.blocks.row((run->y - patch.y) / patch.block);
      for (int x = run->begin; x < run->end; ++x, back = product(back, next)) {
        blocks((x - patch.x) / patch.block) += product(*value++, std::complex<float>(back));
      }
    }
  }
}

const Eigen::MatrixXcf& PieceMoments::at(int piece, const FarPoints& points) {
  const Patch& patch = patches_[piece];
  const PupilPiece& p = pieces_[piece];
  const auto side = int(patch.blocks.rows());
  const double bin_px = grid_.bin_px;
  const auto places = [&](int first, double first_px) {
    const double middle = first_px + bin_px * (first + 0.5 * (patch.block - 1));
    const double last = middle + bin_px * patch.block * (side - 1);
    return Eigen::VectorXd(Eigen::VectorXd::LinSpaced(side, middle, last));
  };
  const Vec2 first_px = grid_.at_px(0.0, 0.0);
  const double step_cpp = window_.step_cpp * points.step_px;
  const Vec2 from_cpp = window_.origin_cpp + window_.step_cpp * points.first_px - patch.carrier_cpp;
  fill_kernel({from_cpp.x, step_cpp, points.width, bin_px, patch.block},
              places(patch.x, first_px.x), p.centre_px.x, p.radius_px, along_x_);
  fill_kernel({from_cpp.y, step_cpp, points.height, bin_px, patch.block},
              places(patch.y, first_px.y), p.centre_px.y, p.radius_px, along_y_);
  const Eigen::Index width = points.width, height = points.height;
  half_.resize(along_x_.rows(), side);  // each power of xi has `width` rows
  multiply_by_transposed(along_x_, patch.blocks, half_);
  moments_.resize(width * height, kCount);
  Eigen::Index column = 0;
  for (int a = 0; a <= kDegree; ++a) {
    const Eigen::Index powers = kDegree - a + 1;  // of eta
    Eigen::Map<Eigen::MatrixXcf> out(moments_.col(column).data(), width, powers * height);
    multiply_by_transposed(half_.middleRows(a * width, width), along_y_.topRows(powers * height),
                           out);
    column += powers;
  }
  return moments_;
}

}  // namespace ovws
