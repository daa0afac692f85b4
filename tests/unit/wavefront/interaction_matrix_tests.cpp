/// Interaction matrices from push-pull pokes: accuracy, noise, and what is refused.
#include "core/wavefront/interaction_matrix.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/decompositions.hpp"
#include "core/wavefront/reconstructor.hpp"
#include "tests/unit/wavefront/push_pull_bench.hpp"

namespace ovws {
namespace {

constexpr double kNoisePx = 0.01;
constexpr double kAnyDrift = 1e9;

double column_error(const InteractionMatrix& matrix, const Eigen::MatrixXd& truth) {
  return (matrix.slopes - truth).cwiseAbs().maxCoeff();
}

TEST(InteractionMatrix, IsTheTruthWithinItsStandardErrors) {
  PushPullBench bench;
  bench.noise_px = kNoisePx;
  const auto matrix = interaction_matrix(bench.run(), kAnyDrift).value();
  EXPECT_EQ(matrix.modes_j, bench.modes_j);
  EXPECT_TRUE(matrix.lost_spots.empty());
  EXPECT_TRUE(matrix.dropped.empty());
  // A difference has sqrt 2 times the noise, and is divided by twice the amplitude.
  const double error = kNoisePx * std::sqrt(2.0) / (2.0 * bench.amplitude_waves);
  EXPECT_NEAR(matrix.standard_error.maxCoeff(), error, 1e-6);
  const Eigen::MatrixXd normal = (matrix.slopes - bench.truth).cwiseQuotient(matrix.standard_error);
  EXPECT_NEAR(normal.squaredNorm() / double(normal.size()), 1.0, 0.15);  // of 684 numbers
  EXPECT_LT(normal.cwiseAbs().maxCoeff(), 5.0);
  EXPECT_NEAR(relative_noise(matrix, 4),
              error * std::sqrt(double(normal.rows())) / bench.truth.col(4).norm(), 0.01);
}

TEST(InteractionMatrix, HasTheSingularValuesOfItsColumns) {
  PushPullBench bench;
  const auto matrix = interaction_matrix(bench.run(), kAnyDrift).value();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(bench.truth);
  EXPECT_LT((singular_values(matrix.slopes) - svd.singularValues()).cwiseAbs().maxCoeff(),
            1e-4 * svd.singularValues()[0]);
}

TEST(InteractionMatrix, DropsSpotsThatAnyImageLoses) {
  PushPullBench bench;
  PushPullRun run = bench.run();
  const Vec2 nowhere{NAN, NAN};
  run.modes[2].plus.at_px[3] = nowhere;
  run.modes[7].minus.at_px[11] = nowhere;
  run.after.at_px[15] = nowhere;
  const auto matrix = interaction_matrix(run, kAnyDrift).value();
  EXPECT_EQ(matrix.lost_spots, (std::vector<int>{3, 11, 15}));
  EXPECT_EQ(matrix.modes_j, bench.modes_j);
  Eigen::MatrixXd truth = bench.truth;
  for (const int spot : matrix.lost_spots) truth.middleRows(2 * spot, 2).setZero();
  EXPECT_LT(column_error(matrix, truth), 1e-4);
  // Reconstruction with the matrix does not use these spots, and is right.
  const Reconstructor reconstructor(matrix.slopes, matrix.modes_j, bench.rest_px);
  std::vector<SpotFix> spots = bench.shown({4, 0.3});
  for (const int spot : matrix.lost_spots) spots[std::size_t(spot)].x += 5.0F;
  auto scratch = reconstructor.make_scratch();
  std::vector<float> waves(matrix.modes_j.size());
  ASSERT_TRUE(reconstructor.solve(spots, scratch, waves).determined);
  for (std::size_t k = 0; k < waves.size(); ++k) {
    EXPECT_NEAR(waves[k], matrix.modes_j[k] == 4 ? 0.3 : 0.0, 1e-4);
  }
}

TEST(InteractionMatrix, DropsTheModesThatItCannotDetermineAndSaysWhy) {
  PushPullBench bench;
  bench.noise_px = 0.1 * kNoisePx;
  bench.truth.col(5) *= 0.002;              // hardly moves a spot
  bench.truth.col(8) = bench.truth.col(2);  // the same as another
  PushPullRun run = bench.run();
  for (std::size_t i = 0; i < 6; ++i) run.modes[10].plus.at_px[i] = {NAN, NAN};
  const auto matrix = interaction_matrix(run, kAnyDrift).value();
  ASSERT_EQ(matrix.dropped.size(), 3u);
  const auto reason_of = [&matrix](int j) {
    const auto at = std::find_if(matrix.dropped.begin(), matrix.dropped.end(),
                                 [j](const DroppedMode& one) { return one.j == j; });
    return at == matrix.dropped.end() ? "" : at->reason;
  };
  EXPECT_NE(reason_of(6).find("noise"), std::string::npos) << reason_of(6);
  EXPECT_NE(reason_of(9).find("not determined"), std::string::npos) << reason_of(9);
  EXPECT_NE(reason_of(11).find("lose the spots 0, 1, 2, 3, 4, 5"), std::string::npos)
      << reason_of(11);
  EXPECT_TRUE(matrix.lost_spots.empty());  // the mode is dropped, its spots stay
  EXPECT_EQ(matrix.modes_j.size(), bench.modes_j.size() - 3);
  EXPECT_EQ(determined_modes(matrix.slopes), int(matrix.modes_j.size()));
}

TEST(InteractionMatrix, DropsAModeThatOnlyNoiseDistinguishesFromAnother) {
  PushPullBench bench;
  bench.noise_px = kNoisePx;
  bench.truth.col(8) = bench.truth.col(2);
  const auto matrix = interaction_matrix(bench.run(), kAnyDrift).value();
  ASSERT_EQ(matrix.dropped.size(), 1u);
  EXPECT_EQ(matrix.dropped[0].j, 9);
}

TEST(InteractionMatrix, TakesEachModeByItsOwnAmplitude) {
  PushPullBench bench;
  PushPullRun run = bench.run();
  run.modes[4] = {5, 0.025, bench.means(4, 0.025), bench.means(4, -0.025)};
  const auto matrix = interaction_matrix(run, kAnyDrift).value();
  EXPECT_EQ(matrix.amplitude_waves[3], 0.1);
  EXPECT_EQ(matrix.amplitude_waves[4], 0.025);
  EXPECT_LT(column_error(matrix, bench.truth), 1e-4);
}

TEST(InteractionMatrix, KnowsHowFarTheZeroDrifted) {
  PushPullBench bench;
  bench.noise_px = kNoisePx;
  PushPullRun run = bench.run();
  const auto still = interaction_matrix(run, 0.5).value();
  EXPECT_NEAR(still.drift_noise_px, kNoisePx * std::sqrt(2.0), 1e-6);
  EXPECT_NEAR(still.drift_px, still.drift_noise_px, 0.5 * still.drift_noise_px);
  for (Vec2& at : run.after.at_px) at = at + Vec2{0.3, -0.3};
  EXPECT_NEAR(interaction_matrix(run, 0.5)->drift_px, 0.3, 0.01);
  const auto moved = interaction_matrix(run, 0.2);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().code, Errc::refused);
  EXPECT_NE(moved.error().reason.find("moved by 0.3"), std::string::npos) << moved.error().reason;
}

TEST(InteractionMatrix, IsRefusedWithoutSpotsOrModes) {
  PushPullBench bench;
  PushPullRun run = bench.run();
  for (std::size_t i = 2; i < bench.rest_px.size(); ++i) run.before.at_px[i] = {NAN, NAN};
  const auto few = interaction_matrix(run, kAnyDrift);
  ASSERT_FALSE(few);
  EXPECT_NE(few.error().reason.find("only 2 spots"), std::string::npos) << few.error().reason;
  bench.truth.setZero();
  const auto still = interaction_matrix(bench.run(), kAnyDrift);
  ASSERT_FALSE(still);
  EXPECT_NE(still.error().reason.find("no mode"), std::string::npos) << still.error().reason;
}

TEST(GivenMatrix, IsTakenAsItIs) {
  const PushPullBench bench;
  Eigen::MatrixXf slopes = bench.truth.cast<float>();
  slopes.middleRows(2 * 3, 2).setZero();
  const Eigen::MatrixXf error = Eigen::MatrixXf::Constant(slopes.rows(), slopes.cols(), 0.01F);
  const auto matrix = interaction_matrix(bench.modes_j, 0.25, slopes, error).value();
  EXPECT_EQ(matrix.source, MatrixSource::set);
  EXPECT_EQ(matrix.modes_j, bench.modes_j);
  EXPECT_EQ(matrix.amplitude_waves, std::vector<double>(bench.modes_j.size(), 0.25));
  EXPECT_EQ(matrix.lost_spots, std::vector<int>{3});
  EXPECT_EQ(matrix.slopes, slopes.cast<double>());
  EXPECT_EQ(matrix.standard_error, error.cast<double>());
}

TEST(GivenMatrix, IsRefusedIfItDoesNotDetermineItsModes) {
  const PushPullBench bench;
  const Eigen::MatrixXf good = bench.truth.cast<float>();
  const Eigen::MatrixXf exact = Eigen::MatrixXf::Zero(good.rows(), good.cols());
  const auto reason = [&](const Eigen::MatrixXf& slopes, const Eigen::MatrixXf& error) {
    const auto matrix = interaction_matrix(bench.modes_j, 0.25, slopes, error);
    return matrix ? std::string() : matrix.error().field + ": " + matrix.error().reason;
  };
  EXPECT_EQ(reason(good, exact), "");
  Eigen::MatrixXf changed = good;
  changed.col(4).setZero();
  EXPECT_EQ(reason(changed, exact), "matrix: j = 5: it moves no spot");
  changed = good;
  changed.col(4) = 2.0F * good.col(1);
  EXPECT_NE(reason(changed, exact).find("matrix: j = 5: it is not determined"), std::string::npos);
  Eigen::MatrixXf noisy = exact;
  noisy.col(2) = 0.2F * good.col(2).cwiseAbs();
  EXPECT_NE(reason(good, noisy).find("matrix: j = 3: its noise is 20 %"), std::string::npos);
  EXPECT_NE(reason(exact, exact).find("only 0 spots move"), std::string::npos);
}

}  // namespace
}  // namespace ovws
