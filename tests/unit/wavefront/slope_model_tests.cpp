/// Slope matrix against analytic integrals and brute-force sums.
#include "core/wavefront/slope_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/optics/zernike.hpp"

namespace ovws {
namespace {

constexpr double kPxPerCycle = 1928.3;
const std::vector<double> kRadii{kGradientTilt, kZernikeTilt, kVortexTilt, 0.7, 0.2};

double lg_radius(int charge, double kernel_radius) {
  return tilt_radius(charge, {TrackerKind::lg, kernel_radius});
}

SensorConfig sensor() {
  return {};
}
Lattice lattice() {
  return make_lattice(sensor(), SlmGeometry{}).value();
}

Eigen::MatrixXd slopes(double model, std::vector<int> modes) {
  return slope_matrix(lattice(), sensor(), modes, model, kPxPerCycle);
}

/// One subaperture that is the whole pupil: modes are then polynomials about its own centre.
Eigen::MatrixXd whole_pupil(double model, std::vector<int> modes) {
  SensorConfig s;
  Lattice one{s.pupil_diameter_px, {{{0.0, 0.0}, {0.0, 0.0}}}};
  return slope_matrix(one, s, modes, model, kPxPerCycle);
}

TEST(SlopeModel, OfAPureTiltIsItsGradientForEveryRadius) {
  const double gradient = 2.0 / (0.5 * 768.0);  // RMS-normalised tilt 2 rho: waves per SLM pixel
  for (const double model : kRadii) {
    const Eigen::MatrixXd m = slopes(model, {1, 2});
    ASSERT_EQ(m.rows(), 38);
    for (int i = 0; i < 19; ++i) {
      EXPECT_NEAR(m(2 * i, 1), kPxPerCycle * gradient, 1e-9) << "tip (j = 2) moves along x";
      EXPECT_NEAR(m(2 * i + 1, 1), 0.0, 1e-9);
      EXPECT_NEAR(m(2 * i + 1, 0), kPxPerCycle * gradient, 1e-9) << "tilt (j = 1) moves along y";
      EXPECT_NEAR(m(2 * i, 0), 0.0, 1e-9);
    }
  }
}

TEST(SlopeModel, TurnsWithTheCamera) {
  const PxPerCycle quarter_turn{0.0, -kPxPerCycle, kPxPerCycle, 0.0};  // +x of the SLM is +y
  const std::vector<int> modes{1, 2, 3, 8};
  const Eigen::MatrixXd straight = slopes(kVortexTilt, modes);
  const Eigen::MatrixXd turned =
      slope_matrix(lattice(), sensor(), modes, kVortexTilt, quarter_turn);
  for (Eigen::Index i = 0; i + 1 < straight.rows(); i += 2) {
    EXPECT_LT((turned.row(i) + straight.row(i + 1)).norm(), 1e-9);
    EXPECT_LT((turned.row(i + 1) - straight.row(i)).norm(), 1e-9);
  }
}

TEST(SlopeModel, OfPistonIsNothing) {
  for (const double model : kRadii) EXPECT_NEAR(slopes(model, {0}).norm(), 0.0, 1e-9);
}

TEST(SlopeModel, OfFocusAndAstigmatismIsTheGradientAtTheCentre) {
  // The odd harmonics of a quadratic phase are linear: all rings agree on gradient(centre).
  const Lattice l = lattice();
  for (const double model : kRadii) {
    const std::vector<int> modes{3, 4, 5};
    const Eigen::MatrixXd m = slopes(model, modes);
    for (std::size_t i = 0; i < l.subapertures.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const Vec2 g = zernike_gradient(modes[k], (1.0 / 384.0) * l.subapertures[i].centre_px);
        EXPECT_NEAR(m(2 * i, k), kPxPerCycle * g.x / 384.0, 1e-9);
        EXPECT_NEAR(m(2 * i + 1, k), kPxPerCycle * g.y / 384.0, 1e-9);
      }
    }
  }
}

TEST(SlopeModel, ReadsComaInsideASubapertureAsTheDesignSays) {
  // r^3 cos t over a circle of radius 1 has the slope 1 for G-tilt and 0.6 for V-tilt (Z-tilt:
  // 2/3). Coma Z(3,1) = sqrt(8) (3 r^3 - 2 r) cos t.
  const double px = kPxPerCycle / 384.0 * std::sqrt(8.0);
  EXPECT_NEAR(whole_pupil(kGradientTilt, {8})(0, 0), px * (3 * 1.0 - 2), 1e-9);
  EXPECT_NEAR(whole_pupil(kVortexTilt, {8})(0, 0), px * (3 * 0.6 - 2), 1e-9);
  EXPECT_NEAR(whole_pupil(kZernikeTilt, {8})(0, 0), 0.0, 1e-9);
  EXPECT_NEAR(whole_pupil(kVortexTilt, {7})(1, 0), px * (3 * 0.6 - 2), 1e-9);
  EXPECT_NEAR(whole_pupil(kVortexTilt, {7})(0, 0), 0.0, 1e-9);
}

TEST(SlopeModel, OfAKernelTendsToVTiltAndZTiltAsTheKernelShrinks) {
  EXPECT_NEAR(lg_radius(1, 0.02), kVortexTilt, 1e-3);
  EXPECT_NEAR(lg_radius(0, 0.02), kZernikeTilt, 1e-3);
}

TEST(SlopeModel, OfAKernelLooksLessAtTheRimTheWiderItIs) {
  // r^3 cos t again: an independent numpy model of the kernel gave 0.547 for w = 0.3 and 0.493 for
  // w = 0.4 with charge 1, and 0.642 for w = 0.5 with charge 0.
  const double px = kPxPerCycle / 384.0 * std::sqrt(8.0);
  const auto cubic = [&](double model) { return (whole_pupil(model, {8})(0, 0) / px + 2.0) / 3.0; };
  EXPECT_NEAR(cubic(lg_radius(1, 0.3)), 0.547, 0.002);
  EXPECT_NEAR(cubic(lg_radius(1, 0.4)), 0.493, 0.002);
  EXPECT_NEAR(cubic(lg_radius(0, 0.5)), 0.642, 0.002);
  EXPECT_GT(lg_radius(1, 0.7), 0.0);
}

TEST(SlopeModel, OfACharge_lDoesNotDependOnItsSign) {
  for (const int charge : {1, 2})
    EXPECT_NEAR(lg_radius(charge, 0.4), lg_radius(-charge, 0.4), 1e-12);
}

TEST(SlopeModel, IsTheIntegralOfTheFirstHarmonicThatABruteForceSumApproaches) {
  // Every mode up to n = 6 over one off-centre subaperture, midpoint rule with 400 x 400 points. A
  // ring is V-tilt up to the fifth order over the subaperture, and G-tilt of any order.
  const Lattice l = lattice();
  const int i = 4;
  std::vector<int> modes;
  for (int j = 1; j < 28; ++j) modes.push_back(j);
  const Eigen::MatrixXd vortex = slopes(kVortexTilt, modes);
  const Eigen::MatrixXd mean = slopes(kGradientTilt, modes);
  const double radius = 0.5 * l.diameter_px;
  for (std::size_t k = 0; k < modes.size(); ++k) {
    Vec2 v, g;
    double first_moment = 0.0, area = 0.0;
    for (int a = 0; a < 400; ++a) {
      for (int b = 0; b < 400; ++b) {
        const Vec2 r{(a + 0.5) / 200.0 - 1.0, (b + 0.5) / 200.0 - 1.0};
        if (norm(r) > 1.0) continue;
        const Vec2 at = (1.0 / 384.0) * (l.subapertures[i].centre_px + radius * r);
        v = v + (zernike(modes[k], at) / norm(r)) * r;
        g = g + zernike_gradient(modes[k], at);
        first_moment += norm(r);
        area += 1.0;
      }
    }
    const double to_px = kPxPerCycle / radius / (0.5 * first_moment);
    EXPECT_NEAR(vortex(2 * i, k), to_px * v.x, 0.2) << modes[k];
    EXPECT_NEAR(vortex(2 * i + 1, k), to_px * v.y, 0.2) << modes[k];
    EXPECT_NEAR(mean(2 * i, k), kPxPerCycle / 384.0 / area * g.x, 0.15) << modes[k];
    EXPECT_NEAR(mean(2 * i + 1, k), kPxPerCycle / 384.0 / area * g.y, 0.15) << modes[k];
  }
}

TEST(SlopeModel, OfTheHighestModesDoesNotAlias) {
  const Eigen::MatrixXd m = whole_pupil(kGradientTilt, {osa_index({19, 19})});
  EXPECT_NEAR(m.norm(), 0.0, 1e-9);  // a pure 19th harmonic has no first harmonic
}

TEST(SlopeModel, IsChosenByTheTrackerInUse) {
  EXPECT_EQ(tilt_radius(0, {TrackerKind::centroid, 0.4}), kGradientTilt);
  EXPECT_EQ(tilt_radius(0, {TrackerKind::thresholded, 0.4}), kZernikeTilt);
  EXPECT_EQ(tilt_radius(0, {TrackerKind::weighted, 0.4}), lg_radius(0, 0.5));
  EXPECT_EQ(tilt_radius(1, {TrackerKind::fit, 0.3}), lg_radius(1, 0.3));
}

}  // namespace
}  // namespace ovws
