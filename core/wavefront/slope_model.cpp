#include "core/wavefront/slope_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/tracking/centroid.hpp"

namespace ovws {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMinRadius = 0.1;  // a wide kernel reads almost the gradient at the centre

/// Ring radius of trackers that find the zero of Psi (LG, weighted). With the pupil field P = exp(i
/// l t) and the kernel's transfer function g(a) = exp(-(pi w |a| / d)^2), Psi(0) = 0. A small phase
/// phi shifts the zero by the mean of phi under q(a) = Re conj(P(a)) integral P(b) (a - b) g(a - b)
/// db. By symmetry q points along a, so that a = (r, 0) suffices. `kernel_radius`: w, units of
/// lambda/d.
double kernel_ring(int charge, double kernel_radius) {
  constexpr int kRings = 24, kAngles = 48;                  // midpoint rule
  const double k = std::pow(0.5 * kPi * kernel_radius, 2);  // radius of the pupil = 1 = d/2
  double of_tilt = 0.0, of_coma = 0.0;
  for (int i = 0; i < kRings; ++i) {
    const double r = (i + 0.5) / kRings;
    double q = 0.0;
    for (int n = 0; n < kRings * kAngles; ++n) {
      const double b = (n / kAngles + 0.5) / kRings, t = 2.0 * kPi * (n % kAngles) / kAngles;
      const double along = b * std::cos(t);
      q +=
          b * std::cos(charge * t) * (r - along) * std::exp(-k * (r * r + b * b - 2.0 * r * along));
    }
    of_tilt += q * r * r;
    of_coma += q * r * r * r * r;
  }
  return std::sqrt(std::clamp(of_coma / of_tilt, kMinRadius * kMinRadius, 1.0));
}

}  // namespace

double tilt_radius(int charge, const TrackingConfig& tracking) {
  switch (tracking.tracker) {
    case TrackerKind::centroid:
      return kGradientTilt;
    case TrackerKind::thresholded:
      return kZernikeTilt;
    case TrackerKind::weighted:
      return kernel_ring(charge, WeightedTracker::kWindowRadius);
    case TrackerKind::lg_contour:
    case TrackerKind::lg:
    case TrackerKind::fit:
      return kernel_ring(charge, lg_kernel_radius(tracking, charge));
  }
  return kGradientTilt;
}

std::vector<double> tilt_radii(const Lattice& lattice, const TrackingConfig& tracking) {
  std::map<int, double> of_size;  // the radius takes a millisecond to compute
  std::vector<double> radii;
  for (const Subaperture& s : lattice.subapertures) {
    const auto [known, is_new] = of_size.try_emplace(std::abs(s.charge), 0.0);
    if (is_new) known->second = tilt_radius(s.charge, tracking);
    radii.push_back(known->second);
  }
  return radii;
}

double position_fit_tilt_radius(int charge) {
  constexpr std::array<double, 9> kOfCharge{0.787, 0.826, 0.850, 0.867, 0.882,
                                            0.893, 0.903, 0.911, 0.917};
  return kOfCharge[std::min(std::size_t(std::abs(charge)), kOfCharge.size() - 1)];
}

Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, double tilt_radius,
                             const PxPerCycle& px_per_cycle) {
  const std::vector<double> tilt_radii(lattice.subapertures.size(), tilt_radius);
  return slope_matrix(lattice, sensor, modes_j, tilt_radii, px_per_cycle);
}

Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, std::span<const double> tilt_radii,
                             const PxPerCycle& px_per_cycle) {
  constexpr int kAngles = 48;  // exact for modes up to n = 20
  const double pupil_radius = 0.5 * sensor.pupil_diameter_px;
  Eigen::MatrixXd slopes =
      Eigen::MatrixXd::Zero(2 * Eigen::Index(lattice.subapertures.size()), modes_j.size());
  const int last_j = modes_j.empty() ? 0 : *std::max_element(modes_j.begin(), modes_j.end());
  std::vector<double> values(std::size_t(last_j) + 1);
  for (std::size_t i = 0; i < lattice.subapertures.size(); ++i) {
    const double radius = tilt_radii[i] * 0.5 * lattice.diameter_px;
    for (int n = 0; n < kAngles; ++n) {
      const double t = 2.0 * kPi * n / kAngles;
      const Vec2 direction{std::cos(t), std::sin(t)};
      const Vec2 at = lattice.subapertures[i].centre_px + radius * direction;
      zernike_values((1.0 / pupil_radius) * at, values);
      for (std::size_t k = 0; k < modes_j.size(); ++k) {
        slopes(2 * i, k) += values[std::size_t(modes_j[k])] * direction.x;
        slopes(2 * i + 1, k) += values[std::size_t(modes_j[k])] * direction.y;
      }
    }
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      const Vec2 sum{slopes(2 * i, k), slopes(2 * i + 1, k)};
      const Vec2 moved = px_per_cycle * ((2.0 / (kAngles * radius)) * sum);
      slopes(2 * i, k) = moved.x;
      slopes(2 * i + 1, k) = moved.y;
    }
  }
  return slopes;
}

}  // namespace ovws
