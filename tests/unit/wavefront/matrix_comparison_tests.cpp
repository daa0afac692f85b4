/// The diagnosis of matrices that are made wrong on purpose.
#include "core/wavefront/matrix_comparison.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/optics/sensor_model.hpp"
#include "tests/unit/wavefront/push_pull_bench.hpp"

namespace ovws {
namespace {

class Comparison : public testing::Test {
 protected:
  Comparison() { bench.noise_px = 0.01; }

  ModeOperator model() const { return {OperatorKind::slopes, bench.modes_j, bench.model}; }
  MatrixComparison compared() {
    return compare(interaction_matrix(bench.run(), 1e9).value(), model());
  }
  /// Applies a map to every displacement.
  MatrixComparison through(const Eigen::Matrix2d& map) {
    for (Eigen::Index i = 0; i < bench.truth.rows(); i += 2) {
      bench.truth.middleRows<2>(i) = map * bench.model.middleRows<2>(i);
    }
    return compared();
  }
  /// A mirrored camera that shows the base spot in its place: all displacements are mirrored, and
  /// each spot is assigned to the mirrored subaperture.
  MatrixComparison seen_mirrored(double by_x, double by_y) {
    const auto& all = bench.lattice.subapertures;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto other = std::find_if(all.begin(), all.end(), [&](const Subaperture& s) {
        const Vec2 at{by_x * s.centre_px.x, by_y * s.centre_px.y};
        return norm(at - all[i].centre_px) < 1.0;
      });
      EXPECT_NE(other, all.end());
      const auto from = 2 * (other - all.begin()), to = 2 * Eigen::Index(i);
      bench.truth.row(to) = by_x * bench.model.row(from);
      bench.truth.row(to + 1) = by_y * bench.model.row(from + 1);
    }
    return compared();
  }
  static bool says(const MatrixComparison& found, const char* words) {
    return found.words.find(words) != std::string::npos;
  }

  PushPullBench bench;
};

Eigen::Matrix2d turned_by(double degrees) {
  return Eigen::Rotation2Dd(degrees * std::numbers::pi / 180.0).toRotationMatrix();
}

TEST_F(Comparison, FindsNothingWrongWithTheModelItself) {
  const auto found = compared();
  EXPECT_EQ(found.disagreement, Disagreement::none);
  EXPECT_EQ(found.words, "");
  ASSERT_EQ(found.modes.size(), bench.modes_j.size());
  for (const ModeComparison& mode : found.modes) {
    EXPECT_GT(mode.correlation, 0.99) << mode.j;
    EXPECT_GT(mode.factor_standard_error, 0.0);
    EXPECT_NEAR(mode.factor, 1.0, 5.0 * mode.factor_standard_error) << mode.j;
  }
}

TEST_F(Comparison, FindsWrongSigns) {
  const auto all = through(-Eigen::Matrix2d::Identity());
  EXPECT_EQ(all.disagreement, Disagreement::sign);
  EXPECT_TRUE(says(all, "every displacement has the wrong sign")) << all.words;
  for (const ModeComparison& mode : all.modes) EXPECT_NEAR(mode.factor, -1.0, 0.02);
  const auto x = through(Eigen::Vector2d(-1, 1).asDiagonal());
  EXPECT_EQ(x.disagreement, Disagreement::sign);
  EXPECT_TRUE(says(x, "along x have the wrong sign")) << x.words;
  const auto y = through(Eigen::Vector2d(1.05, -1.05).asDiagonal());
  EXPECT_EQ(y.disagreement, Disagreement::sign);
  EXPECT_TRUE(says(y, "along y have the wrong sign")) << y.words;
  bench.truth = bench.model;
  bench.truth.col(6) *= -1.0;
  const auto one = compared();
  EXPECT_EQ(one.disagreement, Disagreement::sign);
  EXPECT_TRUE(says(one, "single modes have the wrong sign: j = 7;")) << one.words;
}

TEST_F(Comparison, FindsExchangedAxes) {
  Eigen::Matrix2d exchange;
  exchange << 0, 1, 1, 0;
  const auto found = through(exchange);
  EXPECT_EQ(found.disagreement, Disagreement::axes);
  EXPECT_TRUE(says(found, "x and y are exchanged")) << found.words;
  EXPECT_TRUE(says(found, "registration.run"));
  EXPECT_EQ(through(-exchange).disagreement, Disagreement::axes);
}

TEST_F(Comparison, FindsAnotherScale) {
  const auto found = through(1.06 * Eigen::Matrix2d::Identity());
  EXPECT_EQ(found.disagreement, Disagreement::scale);
  EXPECT_TRUE(says(found, "1.06")) << found.words;
  EXPECT_TRUE(says(found, "registration.run"));
  EXPECT_EQ(through(1.01 * Eigen::Matrix2d::Identity()).disagreement, Disagreement::none);
}

TEST_F(Comparison, FindsATurn) {
  for (const double degrees : {3.0, -33.0, 44.0}) {
    const auto found = through(turned_by(degrees));
    EXPECT_EQ(found.disagreement, Disagreement::rotation);
    char words[40];
    std::snprintf(words, sizeof words, "rotated by %.0f.", degrees);
    const std::string start(words, std::string(words).size() - 1);
    EXPECT_TRUE(says(found, start.c_str())) << found.words;
  }
  EXPECT_TRUE(says(through(turned_by(90.0)), "rotated by 90 degrees"));
  EXPECT_EQ(through(turned_by(0.3)).disagreement, Disagreement::none);
}

TEST_F(Comparison, FindsALatticeThatIsSeenMirrored) {
  EXPECT_TRUE(says(seen_mirrored(-1, 1), "mirrored along x"));
  EXPECT_TRUE(says(seen_mirrored(1, -1), "mirrored along y"));
  const auto turned = seen_mirrored(-1, -1);
  EXPECT_EQ(turned.disagreement, Disagreement::parity);
  EXPECT_TRUE(says(turned, "rotated by 180 degrees")) << turned.words;
}

TEST_F(Comparison, FindsAnotherOrder) {
  bench.truth.col(2) = bench.model.col(4);
  bench.truth.col(4) = -bench.model.col(2);
  const auto found = compared();
  EXPECT_EQ(found.disagreement, Disagreement::order);
  EXPECT_TRUE(says(found, "j = 3 looks like the model's j = 5,")) << found.words;
  EXPECT_TRUE(says(found, "j = 5 looks like the model's j = 3 with the wrong sign")) << found.words;
}

TEST_F(Comparison, FindsSingleModesThatAreTooLong) {
  bench.truth.col(9) *= 1.5;
  const auto found = compared();
  EXPECT_EQ(found.disagreement, Disagreement::single_modes);
  EXPECT_TRUE(says(found, "j = 10 by 1.50;")) << found.words;
}

TEST_F(Comparison, SaysSoIfNothingExplainsIt) {
  std::mt19937 random(5);
  std::normal_distribution<double> any(0.0, 5.0);
  for (double& value : bench.truth.reshaped()) value = any(random);
  const auto found = compared();
  EXPECT_EQ(found.disagreement, Disagreement::unlike);
  EXPECT_TRUE(says(found, "do not move as the model says")) << found.words;
}

TEST_F(Comparison, LeavesLostSpotsOut) {
  PushPullRun run = bench.run();
  run.modes[3].plus.at_px[4] = {NAN, NAN};
  const auto found = compare(interaction_matrix(run, 1e9).value(), model());
  EXPECT_EQ(found.words, "");
  EXPECT_NEAR(found.modes[3].factor, 1.0, 5.0 * found.modes[3].factor_standard_error);
}

}  // namespace
}  // namespace ovws
