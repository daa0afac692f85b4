/// Slope matrix against analytic integrals and brute-force sums.
#include "core/wavefront/slope_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/optics/zernike.hpp"
#include "core/wavefront/radial_weight.hpp"

namespace ovws {
namespace {

constexpr double kPxPerCycle = 1928.3;
const std::vector<SlopeModel> kModels{SlopeKind::gradient_tilt,
                                      SlopeKind::zernike_tilt,
                                      SlopeKind::vortex_tilt,
                                      {SlopeKind::kernel_tilt, 1, 0.4},
                                      {SlopeKind::kernel_tilt, 2, 0.57},
                                      {SlopeKind::kernel_tilt, 0, 0.5}};

SensorConfig sensor() {
  return {};
}
Lattice lattice() {
  return make_lattice(sensor(), SlmGeometry{}).value();
}

Eigen::MatrixXd slopes(const SlopeModel& model, std::vector<int> modes) {
  return slope_matrix(lattice(), sensor(), modes, model, kPxPerCycle);
}

/// One subaperture that is the whole pupil: modes are then polynomials about its own centre.
Eigen::MatrixXd whole_pupil(const SlopeModel& model, std::vector<int> modes) {
  SensorConfig s;
  Lattice one{s.pupil_diameter_px, {{{0.0, 0.0}, {0.0, 0.0}}}};
  return slope_matrix(one, s, modes, model, kPxPerCycle);
}

TEST(SlopeModel, OfAPureTiltIsItsGradientForEveryKind) {
  const double gradient = 2.0 / (0.5 * 768.0);  // RMS-normalised tilt 2 rho: waves per SLM pixel
  for (const SlopeModel& model : kModels) {
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
  const Eigen::MatrixXd straight = slopes(SlopeKind::vortex_tilt, modes);
  const Eigen::MatrixXd turned =
      slope_matrix(lattice(), sensor(), modes, SlopeKind::vortex_tilt, quarter_turn);
  for (Eigen::Index i = 0; i + 1 < straight.rows(); i += 2) {
    EXPECT_LT((turned.row(i) + straight.row(i + 1)).norm(), 1e-9);
    EXPECT_LT((turned.row(i + 1) - straight.row(i)).norm(), 1e-9);
  }
}

TEST(SlopeModel, OfPistonIsNothing) {
  for (const SlopeModel& model : kModels) EXPECT_NEAR(slopes(model, {0}).norm(), 0.0, 1e-9);
}

TEST(SlopeModel, OfFocusAndAstigmatismIsTheGradientAtTheCentre) {
  // The odd harmonics of a quadratic phase are linear: all kinds agree on gradient(centre).
  const Lattice l = lattice();
  for (const SlopeModel& model : kModels) {
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
  EXPECT_NEAR(whole_pupil(SlopeKind::gradient_tilt, {8})(0, 0), px * (3 * 1.0 - 2), 1e-9);
  EXPECT_NEAR(whole_pupil(SlopeKind::vortex_tilt, {8})(0, 0), px * (3 * 0.6 - 2), 1e-9);
  EXPECT_NEAR(whole_pupil(SlopeKind::zernike_tilt, {8})(0, 0), 0.0, 1e-9);
  EXPECT_NEAR(whole_pupil(SlopeKind::vortex_tilt, {7})(1, 0), px * (3 * 0.6 - 2), 1e-9);
  EXPECT_NEAR(whole_pupil(SlopeKind::vortex_tilt, {7})(0, 0), 0.0, 1e-9);
}

TEST(SlopeModel, OfAKernelTendsToVTiltAndZTiltAsTheKernelShrinks) {
  const std::vector<int> modes{7, 8, 11, 12, 13};
  const SlopeModel vortex(SlopeKind::kernel_tilt, 1, 0.02);
  const SlopeModel bright(SlopeKind::kernel_tilt, 0, 0.02);
  EXPECT_LT((slopes(vortex, modes) - slopes(SlopeKind::vortex_tilt, modes)).norm(),
            1e-3 * slopes(vortex, modes).norm());
  EXPECT_LT((slopes(bright, modes) - slopes(SlopeKind::zernike_tilt, modes)).norm(),
            1e-3 * slopes(bright, modes).norm());
}

TEST(SlopeModel, OfAKernelLooksLessAtTheRimTheWiderItIs) {
  // r^3 cos t again: an independent numpy model of the kernel gave 0.547 for w = 0.3 and 0.493 for
  // w = 0.4 with charge 1, and 0.642 for w = 0.5 with charge 0.
  const double px = kPxPerCycle / 384.0 * std::sqrt(8.0);
  const auto cubic = [&](const SlopeModel& model) {
    return (whole_pupil(model, {8})(0, 0) / px + 2.0) / 3.0;
  };
  EXPECT_NEAR(cubic({SlopeKind::kernel_tilt, 1, 0.3}), 0.547, 0.002);
  EXPECT_NEAR(cubic({SlopeKind::kernel_tilt, 1, 0.4}), 0.493, 0.002);
  EXPECT_NEAR(cubic({SlopeKind::kernel_tilt, 0, 0.5}), 0.642, 0.002);
}

TEST(SlopeModel, OfACharge_lDoesNotDependOnItsSign) {
  for (const int charge : {1, 2}) {
    const SlopeModel plus(SlopeKind::kernel_tilt, charge, 0.4);
    const SlopeModel minus(SlopeKind::kernel_tilt, -charge, 0.4);
    EXPECT_NEAR((slopes(plus, {8, 12}) - slopes(minus, {8, 12})).norm(), 0.0, 1e-9);
  }
}

TEST(SlopeModel, IntegratesExactlyWhatABruteForceSumApproaches) {
  // Every mode up to n = 6 over one off-centre subaperture, midpoint rule with 400 x 400 points.
  const Lattice l = lattice();
  const int i = 4;
  std::vector<int> modes;
  for (int j = 1; j < 28; ++j) modes.push_back(j);
  const Eigen::MatrixXd vortex = slopes(SlopeKind::vortex_tilt, modes);
  const Eigen::MatrixXd mean = slopes(SlopeKind::gradient_tilt, modes);
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
    EXPECT_NEAR(vortex(2 * i, k), to_px * v.x, 0.05) << modes[k];
    EXPECT_NEAR(vortex(2 * i + 1, k), to_px * v.y, 0.05) << modes[k];
    EXPECT_NEAR(mean(2 * i, k), kPxPerCycle / 384.0 / area * g.x, 0.15) << modes[k];
    EXPECT_NEAR(mean(2 * i + 1, k), kPxPerCycle / 384.0 / area * g.y, 0.15) << modes[k];
  }
}

TEST(SlopeModel, OfTheHighestModesIsExactToo) {
  // At the highest radial orders the quadrature must not alias.
  const Eigen::MatrixXd m = whole_pupil(SlopeKind::vortex_tilt, {osa_index({19, 19})});
  EXPECT_NEAR(m.norm(), 0.0, 1e-9);  // a pure 19th harmonic has no first harmonic
  const int j = osa_index({19, 1});
  double sum = 0.0;
  constexpr int kSteps = 200000;
  for (int k = 0; k < kSteps; ++k) {
    const double r = (k + 0.5) / kSteps;
    sum += zernike(j, {r, 0.0}) * r / kSteps;
  }
  const double expected = kPxPerCycle / 384.0 * sum * 3.0;  // 1/2 integral r r dr = 1/6, cos^2: 1/2
  EXPECT_NEAR(whole_pupil(SlopeKind::vortex_tilt, {j})(0, 0), expected, 1e-4);
}

TEST(SlopeModel, IsChosenByTheTrackerInUse) {
  EXPECT_EQ(slope_model(0, {TrackerKind::centroid, 0.4}).kind, SlopeKind::gradient_tilt);
  EXPECT_EQ(slope_model(0, {TrackerKind::thresholded, 0.4}).kind, SlopeKind::zernike_tilt);
  EXPECT_EQ(slope_model(0, {TrackerKind::weighted, 0.4}).kernel_radius, 0.5);
  const SlopeModel lg = slope_model(1, {TrackerKind::lg, 0.3});
  EXPECT_EQ(lg.kind, SlopeKind::kernel_tilt);
  EXPECT_EQ(lg.charge, 1);
  EXPECT_EQ(lg.kernel_radius, 0.3);
  EXPECT_EQ(slope_model(1, {TrackerKind::fit, 0.3}).kind, SlopeKind::kernel_tilt);
  EXPECT_EQ(slope_kind(0), SlopeKind::gradient_tilt);
  EXPECT_EQ(slope_kind(-1), SlopeKind::vortex_tilt);
}

TEST(GaussLegendre, IntegratesPolynomialsOfItsDegree) {
  const auto nodes = gauss_legendre(20);
  for (int power = 0; power < 40; ++power) {
    double sum = 0.0;
    for (const RadialNode& node : nodes) sum += node.weight * std::pow(node.r, power);
    EXPECT_NEAR(sum, 1.0 / (power + 1.0), 1e-14) << power;
  }
}

}  // namespace
}  // namespace ovws
