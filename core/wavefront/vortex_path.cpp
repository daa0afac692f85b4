#include "core/wavefront/vortex_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/decompositions.hpp"
#include "core/wavefront/vortex_field.hpp"

namespace ovws {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// All modes of radial order 1 to 4, and those of orders 5 and 6 that the core's path could mistake
// for coma and defocus.
const std::vector<int> kWavesJ{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 17, 18, 24};
const std::vector<int> kAmplitudeJ{1, 2, 3, 4, 5, 12};  // uneven light
constexpr Index kTilts = 2;                             // the first modes

constexpr int kRing = 6;
constexpr double kRingRadius = 0.4;  // pupil radii

constexpr double kPriorWaves = 0.1, kPriorMotion = 0.1,
                 kPriorLnAmplitude = 0.3;  // standard deviations
constexpr double kPixelError = 0.01;       // of the brightest pixel: noise and what is not modelled
constexpr double kMaxStepWaves = 0.1;      // of one iteration
constexpr int kMaxIterations = 40;
constexpr double kSmallStep = 1e-3, kSmallGain = 1e-4;  // converged: waves, relative cost
constexpr double kMaxDamping = 1e5;
constexpr Index kMinPixels = 16;   // of an image
constexpr double kEnoughPx = 4.0;  // per lambda/D: of finer images only some pixels are used
constexpr Index kFree = 2;         // amplitude and background of each image

/// The pixels of one image that are fitted.
struct Window {
  Vec2 axis;
  VectorXd x, y;             ///< columns and rows, camera pixels from the start
  std::vector<Index> cells;  ///< of the rows x columns: those in the window, lit and known
  VectorXd light;            ///< of these, relative to the brightest
};

/// One image compared with the model.
struct Compared {
  VectorXd residual;
  MatrixXd derivatives;  ///< by coefficient, without what amplitude and background can take
};

VectorXd pick(const MatrixXd& all, const std::vector<Index>& cells) {
  VectorXd picked(Index(cells.size()));
  for (Index k = 0; k < picked.size(); ++k) picked[k] = all(cells[std::size_t(k)]);
  return picked;
}

/// 2 Re(conj(u) du): the change of |u|^2 with that of u.
MatrixXd change_of_square(const Eigen::MatrixXcd& u, const Eigen::MatrixXcd& du) {
  return 2.0 * u.conjugate().cwiseProduct(du).real();
}

Result<Window> window_of(const VortexImage& image, const VortexBeam& beam, Vec2 start_px) {
  const double reach = kVortexWindow * beam.lambda_d_px();
  const Image<float>& light = image.light;
  const int left = std::max(0, int(std::ceil(start_px.x - reach)));
  const int right = std::min(light.width - 1, int(std::floor(start_px.x + reach)));
  const int top = std::max(0, int(std::ceil(start_px.y - reach)));
  const int bottom = std::min(light.height - 1, int(std::floor(start_px.y + reach)));
  const bool is_whole = beam.lit.plane.everything();  // else a step might miss the lit plane
  const int step = is_whole ? std::max(1, int(beam.lambda_d_px() / kEnoughPx)) : 1;
  const Index columns = right < left ? 0 : (right - left) / step + 1;
  const Index rows = bottom < top ? 0 : (bottom - top) / step + 1;
  Window window{image.axis, VectorXd(columns), VectorXd(rows), {}, {}};
  for (Index c = 0; c < columns; ++c) window.x[c] = double(left + c * step) - start_px.x;
  for (Index r = 0; r < rows; ++r) window.y[r] = double(top + r * step) - start_px.y;
  std::vector<double> seen;
  for (Index c = 0; c < columns; ++c) {
    for (Index r = 0; r < rows; ++r) {
      const int px = left + int(c) * step, py = top + int(r) * step;
      const double dn = double(light.at(px, py));
      if (!beam.lit.has(px, py) || !std::isfinite(dn)) continue;
      if (std::hypot(window.x[c], window.y[r]) > reach) continue;
      window.cells.push_back(c * rows + r);
      seen.push_back(dn);
    }
  }
  const double brightest = seen.empty() ? 0.0 : *std::ranges::max_element(seen);
  if (Index(seen.size()) < kMinPixels || !(brightest > 0.0)) {
    return fail(Errc::refused, "camera.roi",
                "too few pixels show the vortex: the region of interest must hold the base spot "
                "and its surroundings, and lambda/D must not be much smaller than a pixel");
  }
  window.light = Eigen::Map<const VectorXd>(seen.data(), Index(seen.size())) / brightest;
  return window;
}

/// Unknowns: the coefficients of the field, then two tilts of each image, because the beam moves
/// between images.
class WindowsFit {
 public:
  WindowsFit(const VortexBeam& beam, std::vector<Window> windows);
  /// Levenberg-Marquardt iterations. False: they do not converge.
  bool iterate();
  VortexPath result(Vec2 start_px) const;

 private:
  /// Sum of squares and normal equations at some unknowns.
  struct Normal {
    double cost = 0.0, squares = 0.0;
    Index pixels = 0;
    MatrixXd matrix;
    VectorXd gradient;
  };
  Index own(std::size_t image) const { return field_.coefficients() + kTilts * Index(image); }
  /// Coefficients of the field in one image.
  VectorXd of_image(const VectorXd& unknowns, std::size_t image) const;
  Vec2 moved_px(const VectorXd& tilts) const {
    return tilts[0] * field_.tilt_px(1) + tilts[1] * field_.tilt_px(2);
  }
  Compared compare(const Window& window, const VectorXd& at) const;
  Normal normal(const VectorXd& unknowns) const;

  VortexField field_;
  std::vector<Window> windows_;
  VectorXd weights_;  ///< of the prior
  VectorXd found_;
  Normal normal_;
};

WindowsFit::WindowsFit(const VortexBeam& beam, std::vector<Window> windows)
    : field_(beam, kWavesJ, kAmplitudeJ), windows_(std::move(windows)) {
  const auto weight = [](double deviation) { return 1.0 / (deviation * deviation); };
  weights_ = VectorXd::Constant(own(windows_.size()), weight(kPriorMotion));
  weights_.head(field_.coefficients()).setConstant(weight(kPriorLnAmplitude));
  weights_.head(Index(kWavesJ.size())).setConstant(weight(kPriorWaves));
  weights_.head(kTilts).setZero();
  found_ = VectorXd::Zero(weights_.size());
  normal_ = normal(found_);
}

VectorXd WindowsFit::of_image(const VectorXd& unknowns, std::size_t image) const {
  VectorXd coefficients = unknowns.head(field_.coefficients());
  coefficients.head(kTilts) += unknowns.segment(own(image), kTilts);
  return coefficients;
}

Compared WindowsFit::compare(const Window& window, const VectorXd& at) const {
  const Eigen::MatrixXcd pupil = field_.pupil(at, window.axis);
  const Eigen::MatrixXcd u = field_.far(pupil, window.x, window.y);
  const VectorXd shape = pick(u.cwiseAbs2(), window.cells);
  MatrixXd free(shape.size(), kFree);
  free << shape, VectorXd::Ones(shape.size());
  const VectorXd levels = least_squares(free, window.light);
  const MatrixXd taken = orthonormal_basis(free);
  Compared out{window.light - free * levels, MatrixXd(shape.size(), field_.coefficients())};
  for (Index k = 0; k < out.derivatives.cols(); ++k) {
    const auto du = field_.far(field_.derivative(pupil, k), window.x, window.y);
    out.derivatives.col(k) = levels[0] * pick(change_of_square(u, du), window.cells);
  }
  out.derivatives -= taken * (taken.transpose() * out.derivatives);
  return out;
}

WindowsFit::Normal WindowsFit::normal(const VectorXd& unknowns) const {
  Normal sum;
  sum.matrix = weights_.asDiagonal();
  sum.gradient = -weights_.cwiseProduct(unknowns);
  constexpr double kWeight = 1.0 / (kPixelError * kPixelError);
  const Index shared = field_.coefficients();
  for (std::size_t k = 0; k < windows_.size(); ++k) {
    const Compared one = compare(windows_[k], of_image(unknowns, k));
    const MatrixXd square = kWeight * one.derivatives.transpose() * one.derivatives;
    const VectorXd gradient = kWeight * one.derivatives.transpose() * one.residual;
    sum.matrix.topLeftCorner(shared, shared) += square;
    sum.matrix.block(0, own(k), shared, kTilts) += square.leftCols(kTilts);
    sum.matrix.block(own(k), 0, kTilts, shared) += square.topRows(kTilts);
    sum.matrix.block(own(k), own(k), kTilts, kTilts) += square.topLeftCorner(kTilts, kTilts);
    sum.gradient.head(shared) += gradient;
    sum.gradient.segment(own(k), kTilts) += gradient.head(kTilts);
    sum.squares += one.residual.squaredNorm();
    sum.pixels += one.residual.size();
  }
  sum.cost = kWeight * sum.squares + weights_.dot(unknowns.cwiseAbs2());
  return sum;
}

bool WindowsFit::iterate() {
  double damping = 1e-2;
  for (int k = 0; k < kMaxIterations; ++k) {
    MatrixXd damped = normal_.matrix;
    damped.diagonal() *= 1.0 + damping;
    VectorXd step = solve_symmetric(damped, normal_.gradient);
    const double largest = step.cwiseAbs().maxCoeff();
    if (!std::isfinite(largest)) return false;
    step *= std::min(1.0, kMaxStepWaves / std::max(largest, 1e-300));
    Normal next = normal(found_ + step);
    if (next.cost <= normal_.cost) {
      const double gain = normal_.cost - next.cost;
      found_ += step;
      normal_ = std::move(next);
      damping = std::max(1e-6, damping / 5.0);
      if (gain <= kSmallGain * normal_.cost && step.cwiseAbs().maxCoeff() < kSmallStep) return true;
    } else if (largest < kSmallStep) {
      return true;
    } else if ((damping *= 5.0) > kMaxDamping) {
      return true;  // no step in any direction is better
    }
  }
  return false;
}

VortexPath WindowsFit::result(Vec2 start_px) const {
  VortexPath path;
  const auto images = Index(windows_.size());
  const Index unknowns = found_.size() + kFree * images;
  const double variance = normal_.squares / double(std::max<Index>(1, normal_.pixels - unknowns));
  const MatrixXd covariance =
      variance / (kPixelError * kPixelError) * Cholesky(normal_.matrix).inverse();
  for (Index k = kTilts; k < Index(kWavesJ.size()); ++k) {
    path.modes.push_back({kWavesJ[std::size_t(k)], found_[k]});
    path.standard_error.push_back(std::sqrt(covariance(k, k)));
  }
  // Only the prior tells the common tilt from the mean of the images' own ones.
  VectorXd tilts = VectorXd::Zero(kTilts);
  for (std::size_t k = 0; k < windows_.size(); ++k) {
    tilts += of_image(found_, k).head(kTilts) / double(images);
  }
  const Vec2 middle = moved_px(tilts);
  path.middle_px = start_px + middle;
  double motions = 0.0;
  for (std::size_t k = 0; k < windows_.size(); ++k) {
    const VectorXd at = of_image(found_, k);
    const Vec2 motion = moved_px(at.head(kTilts) - tilts);
    motions += motion.x * motion.x + motion.y * motion.y;
    const Vec2 axis = windows_[k].axis;
    const auto core = field_.core(field_.pupil(at, axis), axis, middle + motion);
    path.cores_px.push_back(core ? std::optional(start_px + *core - motion) : std::nullopt);
  }
  path.motion_px = std::sqrt(motions / double(images));
  path.residual = std::sqrt(variance);
  return path;
}

}  // namespace

std::vector<Vec2> vortex_axes() {
  std::vector<Vec2> axes{{}};
  for (int k = 0; k < kRing; ++k) {
    const double turn = 2.0 * std::numbers::pi * k / kRing;
    axes.push_back(kRingRadius * Vec2{std::cos(turn), std::sin(turn)});
  }
  return axes;
}

Result<VortexPath> fit_vortex_path(std::span<const VortexImage> images, const VortexBeam& beam,
                                   Vec2 start_px) {
  std::vector<Window> windows;
  for (const VortexImage& image : images) {
    auto window = window_of(image, beam, start_px);
    if (!window) return fail(window.error());
    windows.push_back(std::move(*window));
  }
  WindowsFit fit(beam, std::move(windows));
  if (!fit.iterate()) {
    return fail(Errc::refused, "",
                "no wavefront explains the images of the vortex: check that nothing moves, and run "
                "registration.run");
  }
  return fit.result(start_px);
}

}  // namespace ovws
