#include "core/wavefront/vortex_field.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

#include "core/base/angle.hpp"

namespace ovws {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;

constexpr Index kCells = 64;  // across the pupil
constexpr int kParts = 8;     // of a cell's side, for its lit share

constexpr double kCoreShift = 0.93;  // core's distance in lambda/D per pupil radius, flat wavefront
constexpr int kMaxNewton = 50;
constexpr double kMaxStep = 0.3, kConverged = 1e-8, kMaxCore = 2.0;  // lambda/D

/// exp(-2 pi i p q) for pixels p (rows) and cells q (columns).
Eigen::MatrixXcd phasors(const Eigen::VectorXd& p, const Eigen::VectorXd& q) {
  const Eigen::MatrixXd turns = -kTwoPi * p * q.transpose();
  return turns.unaryExpr([](double angle) { return std::polar(1.0, angle); });
}

/// Cells along one axis that cover -reach … reach.
Eigen::VectorXd cells(double reach) {
  const double side = 2.0 * reach / kCells;
  return Eigen::VectorXd::LinSpaced(kCells, 0.5 * side - reach, reach - 0.5 * side);
}

}  // namespace

VortexField::VortexField(const VortexBeam& beam, std::vector<int> waves_j,
                         std::vector<int> amplitude_j)
    : beam_(beam),
      amplitude_(Eigen::MatrixXd::Zero(kCells, kCells)),
      x_(kCells, kCells),
      y_(kCells, kCells),
      phases_(Index(waves_j.size())) {
  // q = radius M^-T rho, rho = M^T q / radius: the pupil is an ellipse in q.
  const PxPerCycle& m = beam.px_per_cycle;
  const double radius = 0.5 * beam.pupil_diameter_px, det = m.determinant();
  qx_ = cells(radius / std::abs(det) * std::hypot(m.yy, m.yx));
  qy_ = cells(radius / std::abs(det) * std::hypot(m.xx, m.xy));
  const auto rho = [&](double qx, double qy) {
    return (1.0 / radius) * Vec2{m.xx * qx + m.yx * qy, m.xy * qx + m.yy * qy};
  };
  const double dx = qx_[1] - qx_[0], dy = qy_[1] - qy_[0];
  basis_.resize(kCells * kCells, Index(waves_j.size() + amplitude_j.size()));
  for (Index c = 0; c < kCells; ++c) {
    for (Index r = 0; r < kCells; ++r) {
      const Vec2 at = rho(qx_[c], qy_[r]);
      x_(r, c) = at.x;
      y_(r, c) = at.y;
      for (int part = 0; part < kParts * kParts; ++part) {
        const double px = (part % kParts + 0.5) / kParts - 0.5;
        const double py = (part / kParts + 0.5) / kParts - 0.5;
        if (norm(rho(qx_[c] + px * dx, qy_[r] + py * dy)) <= 1.0) amplitude_(r, c) += 1.0;
      }
      Index k = 0;
      for (const auto* all : {&waves_j, &amplitude_j}) {
        for (const int j : *all) basis_(c * kCells + r, k++) = zernike(j, at);
      }
    }
  }
  amplitude_ /= amplitude_.sum();
}

Eigen::MatrixXcd VortexField::pupil(const Eigen::VectorXd& coefficients, Vec2 axis) const {
  const Index amplitudes = coefficients.size() - phases_;
  const Eigen::VectorXd waves = basis_.leftCols(phases_) * coefficients.head(phases_);
  const Eigen::VectorXd ln = basis_.rightCols(amplitudes) * coefficients.tail(amplitudes);
  Eigen::MatrixXcd field(kCells, kCells);
  for (Index k = 0; k < field.size(); ++k) {
    const double vortex = std::atan2(y_(k) - axis.y, x_(k) - axis.x);
    field(k) =
        std::polar(amplitude_(k) * std::exp(ln[k]), kTwoPi * waves[k] + beam_.charge * vortex);
  }
  return field;
}

Eigen::MatrixXcd VortexField::far(const Eigen::MatrixXcd& pupil, const Eigen::VectorXd& x,
                                  const Eigen::VectorXd& y) const {
  return phasors(y, qy_) * pupil * phasors(x, qx_).transpose();
}

Eigen::MatrixXcd VortexField::derivative(const Eigen::MatrixXcd& pupil, Index k) const {
  const Complex factor = k < phases_ ? Complex(0.0, kTwoPi) : Complex(1.0);
  const Eigen::Map<const Eigen::MatrixXd> mode(basis_.col(k).data(), kCells, kCells);
  return factor * pupil.cwiseProduct(mode.cast<Complex>());
}

std::array<Eigen::MatrixXcd, 2> VortexField::gradient(const Eigen::MatrixXcd& pupil,
                                                      const Eigen::VectorXd& x,
                                                      const Eigen::VectorXd& y) const {
  const Complex factor(0.0, -kTwoPi);
  return {factor * far(pupil * qx_.cast<Complex>().asDiagonal(), x, y),
          factor * far(qy_.cast<Complex>().asDiagonal() * pupil, x, y)};
}

std::optional<Vec2> VortexField::core(const Eigen::MatrixXcd& pupil, Vec2 axis, Vec2 middle) const {
  const double scale_px = beam_.lambda_d_px();
  const Vec2 sideways = double(beam_.charge) * kCoreShift * Vec2{-axis.y, axis.x};
  Vec2 at = middle + (1.0 / beam_.pupil_diameter_px) * (beam_.px_per_cycle * sideways);
  for (int k = 0; k < kMaxNewton; ++k) {
    const Eigen::VectorXd x = Eigen::VectorXd::Constant(1, at.x);
    const Eigen::VectorXd y = Eigen::VectorXd::Constant(1, at.y);
    const Complex u = far(pupil, x, y)(0, 0);
    const auto [by_x, by_y] = gradient(pupil, x, y);
    Eigen::Matrix2d jacobian;
    jacobian << by_x(0, 0).real(), by_y(0, 0).real(), by_x(0, 0).imag(), by_y(0, 0).imag();
    const Eigen::Vector2d step = -jacobian.inverse() * Eigen::Vector2d(u.real(), u.imag());
    const double length = step.norm() / scale_px;
    if (!std::isfinite(length)) return std::nullopt;
    const double part = std::min(1.0, kMaxStep / std::max(length, 1e-300));
    at = at + part * Vec2{step[0], step[1]};
    if (norm(at - middle) > kMaxCore * scale_px) return std::nullopt;
    if (length < kConverged) return at;
  }
  return std::nullopt;
}

Vec2 VortexField::tilt_px(int j) const {
  // Z_1 = 2 y and Z_2 = 2 x over the pupil's radius.
  const double slope = 4.0 / beam_.pupil_diameter_px;
  return beam_.px_per_cycle * (j == 1 ? Vec2{0.0, slope} : Vec2{slope, 0.0});
}

}  // namespace ovws
