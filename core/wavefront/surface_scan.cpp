#include "core/wavefront/surface_scan.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/decompositions.hpp"
#include "core/optics/zernike.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws {
namespace {

constexpr int kOrder = 10;  // maximum radial order
constexpr int kModes = kOrder * (kOrder + 3) / 2;
// The prior's weight of a mode of radial order kPriorOrder, relative to the weight of the mode's
// slopes. The result is insensitive to the weight: a third of kPrior changes a mode by 0.001 waves
// of 0.3.
constexpr double kPrior = 1e-3;
constexpr double kPriorOrder = 4.0;
constexpr double kMinFoundShare = 0.9;

Lattice lattice_of(const ScanGrid& grid) {
  Lattice lattice;
  lattice.diameter_px = grid.probe_diameter_px;
  for (const Vec2 centre : grid.centres_px) lattice.subapertures.push_back({centre, {}});
  return lattice;
}

/// The prior's weight of each mode (inverse variance).
Eigen::VectorXd prior(const std::vector<int>& modes_j, const Eigen::MatrixXd& slopes) {
  const double scale = slopes.colwise().norm().mean();
  Eigen::VectorXd weights(slopes.cols());
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    const double order = zernike_index(modes_j[std::size_t(k)]).n / kPriorOrder;
    weights[k] = kPrior * scale * scale * std::pow(order, 4.0);
  }
  return weights;
}

}  // namespace

ScanGrid scan_grid(double pupil_diameter_px, double probe_diameter_px) {
  constexpr int kRings = 4;
  ScanGrid grid{pupil_diameter_px, probe_diameter_px, {}};
  const double reach = 0.5 * (pupil_diameter_px - probe_diameter_px);
  grid.centres_px.push_back({});
  for (int ring = 1; ring <= kRings; ++ring) {
    const int places = 6 * ring;
    for (int k = 0; k < places; ++k) {
      const double turn = 2.0 * std::numbers::pi * (k + 0.5 * (ring & 1)) / places;
      grid.centres_px.push_back(reach * ring / kRings * Vec2{std::cos(turn), std::sin(turn)});
    }
  }
  return grid;
}

ScanFit::ScanFit(ScanGrid grid, const PxPerCycle& px_per_cycle)
    : grid_(std::move(grid)), modes_j_(kModes) {
  std::iota(modes_j_.begin(), modes_j_.end(), 1);
  SensorConfig sensor;
  sensor.charge = 0;
  sensor.pupil_diameter_px = grid_.pupil_diameter_px;
  slopes_ =
      slope_matrix(lattice_of(grid_), sensor, modes_j_, position_fit_tilt_radius(0), px_per_cycle);
}

Result<ScanFit::Found> ScanFit::fit(const std::vector<std::optional<Vec2>>& at_px,
                                    const std::vector<double>& shown) const {
  const auto spots = Eigen::Index(at_px.size());
  Vec2 sum;
  int found = 0;
  for (const auto& at : at_px) {
    if (!at) continue;
    sum = sum + *at;
    ++found;
  }
  if (found < kMinFoundShare * double(spots)) {
    return fail(
        Errc::refused, "",
        std::to_string(spots - found) + " of " + std::to_string(spots) +
            " positions in the pupil show no spot: check the exposure, that the light fills "
            "the pupil, that the region of interest holds the base spot, and that the "
            "camera has not moved since registration.run");
  }
  const Vec2 mean = (1.0 / found) * sum;
  Eigen::MatrixXd slopes = slopes_;
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(2 * spots);
  for (Eigen::Index i = 0; i < spots; ++i) {
    const auto& at = at_px[std::size_t(i)];
    if (!at) {
      slopes.middleRows(2 * i, 2).setZero();
      continue;
    }
    moved[2 * i] = at->x - mean.x;
    moved[2 * i + 1] = at->y - mean.y;
  }
  const auto on_top = Eigen::Map<const Eigen::VectorXd>(shown.data(), Eigen::Index(shown.size()));
  const Eigen::VectorXd displacements = moved - slopes * on_top;
  Eigen::MatrixXd normal = gram_matrix(slopes);
  normal.diagonal() += prior(modes_j_, slopes);
  const Eigen::MatrixXd inverse = solve_symmetric(normal, Eigen::MatrixXd(slopes.transpose()));
  const Eigen::VectorXd waves = inverse * displacements;
  const double residual = (displacements - slopes * waves).norm();
  // Degrees of freedom: coordinates measured minus those used by the modes and the mean position.
  const double degrees_of_freedom = 2.0 * found - 2.0 - (inverse * slopes).trace();
  const Eigen::VectorXd errors =
      residual / std::sqrt(degrees_of_freedom) * inverse.rowwise().norm();
  return Found{{waves.begin(), waves.end()},
               {errors.begin(), errors.end()},
               residual / std::sqrt(2.0 * found)};
}

}  // namespace ovws
