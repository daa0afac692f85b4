#include "core/wavefront/slope_model.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/tracking/centroid.hpp"
#include "core/wavefront/radial_weight.hpp"

namespace ovws {
namespace {

// The trapezoidal rule is exact for harmonics below the number of angles. The highest is 2n + 2,
// for the highest radial order n = 20 and the first harmonic itself.
constexpr int kAngles = 48;

struct Sample {
  Vec2 at;      ///< in units of the subaperture's radius
  Vec2 weight;  ///< of phi there, for x and y
};

/// Quadrature points and weights of phi, scaled so that a tilt phi = g . at gives the gradient g.
std::vector<Sample> samples_of(const SlopeModel& model) {
  std::vector<Sample> samples;
  double tilt = 0.0;
  for (const RadialNode& node : radial_nodes(model)) {
    tilt += 0.5 * kAngles * node.weight * node.r;
    for (int i = 0; i < kAngles; ++i) {
      const double t = 2.0 * std::numbers::pi * i / kAngles;
      const Vec2 direction{std::cos(t), std::sin(t)};
      samples.push_back({node.r * direction, node.weight * direction});
    }
  }
  for (Sample& s : samples) s.weight = (1.0 / tilt) * s.weight;
  return samples;
}

}  // namespace

SlopeKind slope_kind(int charge) {
  return charge == 0 ? SlopeKind::gradient_tilt : SlopeKind::vortex_tilt;
}

SlopeModel slope_model(int charge, const TrackingConfig& tracking) {
  switch (tracking.tracker) {
    case TrackerKind::centroid:
      return SlopeKind::gradient_tilt;
    case TrackerKind::thresholded:
      return SlopeKind::zernike_tilt;
    case TrackerKind::weighted:
      return {SlopeKind::kernel_tilt, charge, WeightedTracker::kWindowRadius};
    case TrackerKind::lg_contour:
    case TrackerKind::lg:
    case TrackerKind::fit:
      return {SlopeKind::kernel_tilt, charge, lg_kernel_radius(tracking, charge)};
  }
  return slope_kind(charge);
}

Eigen::MatrixXd slope_matrix(const Lattice& lattice, const SensorConfig& sensor,
                             std::span<const int> modes_j, const SlopeModel& model,
                             const PxPerCycle& px_per_cycle) {
  const double pupil_radius = 0.5 * sensor.pupil_diameter_px;
  const double radius = 0.5 * lattice.diameter_px;
  const std::vector<Sample> samples = samples_of(model);
  Eigen::MatrixXd slopes =
      Eigen::MatrixXd::Zero(2 * Eigen::Index(lattice.subapertures.size()), modes_j.size());
  for (std::size_t i = 0; i < lattice.subapertures.size(); ++i) {
    const Vec2 centre = lattice.subapertures[i].centre_px;
    for (std::size_t k = 0; k < modes_j.size(); ++k) {
      Vec2 sum;
      for (const Sample& s : samples) {
        const Vec2 at = (1.0 / pupil_radius) * (centre + radius * s.at);
        sum = sum + zernike(modes_j[k], at) * s.weight;
      }
      const Vec2 moved = px_per_cycle * ((1.0 / radius) * sum);
      slopes(2 * i, k) = moved.x;
      slopes(2 * i + 1, k) = moved.y;
    }
  }
  return slopes;
}

}  // namespace ovws
