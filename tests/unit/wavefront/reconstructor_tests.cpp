/// Round trip: solve recovers the modes from displacements by slope_matrix, whichever spots are
/// lost.
#include "core/wavefront/reconstructor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "core/optics/lattice.hpp"
#include "core/optics/zernike.hpp"
#include "core/wavefront/slope_model.hpp"
#include "tests/support/alloc_guard.hpp"

namespace ovws {
namespace {

class Reconstruct : public testing::Test {
 protected:
  explicit Reconstruct(int across = 5) : modes_(optimal_mode_count(across)) {
    SensorConfig sensor;
    sensor.subapertures_across = across;
    std::iota(modes_.begin(), modes_.end(), 1);
    const Lattice lattice = make_lattice(sensor, SlmGeometry{}).value();
    slopes_ = slope_matrix(lattice, sensor, modes_, kVortexTilt, 1928.3);
    for (const Subaperture& s : lattice.subapertures) {
      reference_.push_back(Vec2{300.25, 200.5} + 0.4 * s.centre_px);
    }
    truth_ = Eigen::VectorXd::LinSpaced(slopes_.cols(), -0.3, 0.45);
  }

  std::vector<SpotFix> spots(const Eigen::VectorXd& modes) const {
    const Eigen::VectorXd d = slopes_ * modes;
    std::vector<SpotFix> fixes;
    for (std::size_t i = 0; i < reference_.size(); ++i) {
      fixes.push_back({.x = float(reference_[i].x + d(2 * i)),
                       .y = float(reference_[i].y + d(2 * i + 1)),
                       .quality = 1.0F});
    }
    return fixes;
  }

  Reconstruction solve(const Reconstructor& r, const std::vector<SpotFix>& fixes) {
    Reconstructor::Scratch scratch = r.make_scratch();
    coefficients_.assign(modes_.size(), -99.0F);
    return r.solve(fixes, scratch, coefficients_);
  }

  void expect_truth(const std::vector<SpotFix>& fixes, double tolerance = 2e-6) {
    const Reconstructor r(slopes_, modes_, reference_);
    const Reconstruction result = solve(r, fixes);
    ASSERT_TRUE(result.determined);
    for (std::size_t k = 0; k < modes_.size(); ++k) {
      EXPECT_NEAR(coefficients_[k], truth_(k), tolerance) << "j = " << modes_[k];
    }
    EXPECT_LT(result.fit_residual_px, 1e-4);  // positions are floats
    EXPECT_NEAR(result.rms_waves, truth_.tail(truth_.size() - 2).norm(), 1e-5);
  }

  std::vector<int> modes_;
  Eigen::MatrixXd slopes_;
  std::vector<Vec2> reference_;
  Eigen::VectorXd truth_;
  std::vector<float> coefficients_;
};

TEST_F(Reconstruct, GivesBackEveryModeInItsPlace) {
  expect_truth(spots(truth_));
  for (int k = 0; k < slopes_.cols(); ++k) {
    truth_ = Eigen::VectorXd::Unit(slopes_.cols(), k);
    expect_truth(spots(truth_));
  }
}

/// Uneven illumination rotates all spots: with spots lost, the modes take that for an aberration.
TEST_F(Reconstruct, LeavesOutWhatIsFittedAsNuisance) {
  Eigen::MatrixXd turn(slopes_.rows(), 1);
  for (std::size_t i = 0; i < reference_.size(); ++i) {
    const Vec2 from = reference_[i] - Vec2{300.25, 200.5};
    turn(2 * Eigen::Index(i), 0) = -from.y;
    turn(2 * Eigen::Index(i) + 1, 0) = from.x;
  }
  auto fixes = spots(truth_);
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    fixes[i].x += float(0.04 * turn(2 * Eigen::Index(i), 0));
    fixes[i].y += float(0.04 * turn(2 * Eigen::Index(i) + 1, 0));
  }
  const Reconstructor plain(slopes_, modes_, reference_);
  const Reconstructor free(slopes_, modes_, reference_, turn);
  for (const std::vector<std::size_t>& lost :
       {std::vector<std::size_t>{}, std::vector<std::size_t>{0, 7, 11}}) {
    auto some = fixes;
    for (const std::size_t i : lost) some[i] = SpotFix{};
    double off = 0.0;
    ASSERT_TRUE(solve(plain, some).determined);
    for (std::size_t k = 2; k < modes_.size(); ++k) {
      off = std::max(off, std::abs(coefficients_[k] - truth_(Eigen::Index(k))));
    }
    EXPECT_EQ(off > 0.02, !lost.empty()) << off;
    const Reconstruction result = solve(free, some);
    ASSERT_TRUE(result.determined);
    EXPECT_LT(result.fit_residual_px, 1e-4);
    for (std::size_t k = 0; k < modes_.size(); ++k) {
      EXPECT_NEAR(coefficients_[k], truth_(Eigen::Index(k)), 1e-5) << "j = " << modes_[k];
    }
  }
}

TEST_F(Reconstruct, OfTheReferenceItselfIsZero) {
  truth_.setZero();
  expect_truth(spots(truth_));
}

TEST_F(Reconstruct, GivesTheSameWithAnySingleSpotLost) {
  for (std::size_t i = 0; i < reference_.size(); ++i) {
    auto fixes = spots(truth_);
    fixes[i] = SpotFix{};
    expect_truth(fixes, 1e-5);
  }
}

TEST_F(Reconstruct, GivesTheSameWithSeveralSpotsLostOrSaysThatItCannot) {
  const Reconstructor r(slopes_, modes_, reference_);
  std::mt19937 random(3);
  std::vector<int> order(reference_.size());
  std::iota(order.begin(), order.end(), 0);
  int determined = 0, asked = 0;
  for (int lost = 2; lost <= 10; ++lost) {
    for (int repeat = 0; repeat < 40; ++repeat) {
      std::shuffle(order.begin(), order.end(), random);
      auto fixes = spots(truth_);
      for (int k = 0; k < lost; ++k) fixes[order[k]] = SpotFix{};
      const Reconstruction result = solve(r, fixes);
      ++asked;
      if (!result.determined) {
        for (const float c : coefficients_) EXPECT_TRUE(std::isnan(c));
        EXPECT_GT(lost, 2) << "two lost spots of 19 never cost a mode";
        continue;
      }
      ++determined;
      for (std::size_t k = 0; k < modes_.size(); ++k) {
        EXPECT_NEAR(coefficients_[k], truth_(k), 5e-5);
      }
    }
  }
  EXPECT_GT(determined, asked / 3);
  EXPECT_LT(determined, asked);  // ten lost of 19 leave 18 numbers for 18 modes: some must fail
}

TEST_F(Reconstruct, IsTheLeastSquaresSolutionOfNoisySpots) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.1);
  auto fixes = spots(truth_);
  for (SpotFix& f : fixes) {
    f.x += float(noise(random));
    f.y += float(noise(random));
  }
  fixes[6] = SpotFix{};
  Eigen::MatrixXd rows(36, slopes_.cols());
  Eigen::VectorXd moves(36);
  for (int i = 0, row = 0; i < 19; ++i) {
    if (i == 6) continue;
    rows.row(row) = slopes_.row(2 * i);
    moves(row++) = double(fixes[i].x) - reference_[i].x;
    rows.row(row) = slopes_.row(2 * i + 1);
    moves(row++) = double(fixes[i].y) - reference_[i].y;
  }
  const Eigen::VectorXd expected = rows.colPivHouseholderQr().solve(moves);
  const Reconstructor r(slopes_, modes_, reference_);
  const Reconstruction result = solve(r, fixes);
  ASSERT_TRUE(result.determined);
  for (int k = 0; k < expected.size(); ++k) EXPECT_NEAR(coefficients_[k], expected(k), 1e-6);
  EXPECT_NEAR(result.fit_residual_px, std::sqrt((moves - rows * expected).squaredNorm() / 36),
              1e-6);
}

/// The residual is the RMS over x and y of the displacements that no mode explains, with and
/// without a lost spot, which is solved in another way.
TEST_F(Reconstruct, ReportsTheResidualThatNoModeExplains) {
  for (const bool one_is_lost : {false, true}) {
    const Eigen::Index rows = slopes_.rows() - (one_is_lost ? 2 : 0);  // the last spot
    const Eigen::MatrixXd tracked = slopes_.topRows(rows);
    Eigen::VectorXd residual = Eigen::VectorXd::Random(rows);
    residual -= tracked * tracked.colPivHouseholderQr().solve(residual);
    auto fixes = spots(truth_);
    for (Eigen::Index row = 0; row < rows; row += 2) {
      fixes[std::size_t(row / 2)].x += float(residual(row));
      fixes[std::size_t(row / 2)].y += float(residual(row + 1));
    }
    if (one_is_lost) fixes.back() = {};
    const Reconstructor r(slopes_, modes_, reference_);
    const Reconstruction result = solve(r, fixes);
    EXPECT_NEAR(result.fit_residual_px, residual.norm() / std::sqrt(double(rows)), 1e-4);
    for (std::size_t k = 0; k < modes_.size(); ++k) EXPECT_NEAR(coefficients_[k], truth_(k), 1e-5);
  }
}

TEST_F(Reconstruct, WithoutAReferenceDeterminesNothing) {
  const Reconstructor r(slopes_, modes_, {});
  EXPECT_FALSE(solve(r, spots(truth_)).determined);
  for (const float c : coefficients_) EXPECT_TRUE(std::isnan(c));
}

TEST_F(Reconstruct, TreatsASpotWithoutAReferenceAsLost) {
  auto fixes = spots(truth_);
  reference_[3] = {std::nan(""), std::nan("")};
  fixes[3].x = 1e6F;
  expect_truth(fixes, 1e-5);
  fixes[12] = SpotFix{};
  expect_truth(fixes, 1e-5);
}

TEST_F(Reconstruct, WithTooFewSpotsDeterminesNothing) {
  const Reconstructor r(slopes_, modes_, reference_);
  auto fixes = spots(truth_);
  for (int i = 0; i < 11; ++i) fixes[i] = SpotFix{};
  EXPECT_FALSE(solve(r, fixes).determined);
  EXPECT_FALSE(solve(r, std::vector<SpotFix>(19)).determined);
}

TEST_F(Reconstruct, OfMoreModesThanTheLatticeDeterminesGivesNothing) {
  // 19 subapertures give 38 numbers, which cannot determine 45 modes.
  SensorConfig sensor;
  const Lattice lattice = make_lattice(sensor, SlmGeometry{}).value();
  std::vector<int> many(45);
  std::iota(many.begin(), many.end(), 1);
  const auto slopes = slope_matrix(lattice, sensor, many, kVortexTilt, 1928.3);
  const Reconstructor r(slopes, many, reference_);
  Reconstructor::Scratch scratch = r.make_scratch();
  std::vector<float> coefficients(45);
  EXPECT_FALSE(r.solve(spots(truth_), scratch, coefficients).determined);
}

TEST_F(Reconstruct, AcceptsNoSetOfSpotsThatLetsNoiseGrowBeyondItsLimit) {
  // With noise of 0.01 px, determined modes must be right to kMaxNoiseGrowth times the full
  // lattice's own error, with room for 5 sigma.
  const Reconstructor r(slopes_, modes_, reference_);
  const Eigen::MatrixXd inverse = (slopes_.transpose() * slopes_).inverse();
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0.0, 0.01);
  std::vector<int> order(19);
  std::iota(order.begin(), order.end(), 0);
  for (int repeat = 0; repeat < 200; ++repeat) {
    std::shuffle(order.begin(), order.end(), random);
    auto fixes = spots(truth_);
    for (int k = 0; k < 1 + repeat % 9; ++k) fixes[order[k]] = SpotFix{};
    for (SpotFix& f : fixes) {
      f.x += float(noise(random));
      f.y += float(noise(random));
    }
    if (!solve(r, fixes).determined) continue;
    for (std::size_t k = 0; k < modes_.size(); ++k) {
      const double sigma = 0.01 * std::sqrt(inverse(k, k)) * Reconstructor::kMaxNoiseGrowth;
      EXPECT_NEAR(coefficients_[k], truth_(k), 5.0 * sigma);
    }
  }
}

TEST_F(Reconstruct, LosesSpotsThatAllOthersContradict) {
  const Reconstructor r(slopes_, modes_, reference_);
  Reconstructor::Scratch scratch = r.make_scratch();
  coefficients_.resize(modes_.size());
  for (int i = 0; i < 19; ++i) {
    for (const int lost : {-1, (i + 5) % 19}) {
      auto fixes = spots(truth_);
      if (lost >= 0) fixes[lost] = SpotFix{};
      fixes[i].x += 11.0F;
      fixes[i].y -= 15.0F;
      fixes[i].peak = 7.0F;
      const test::AllocGuard guard;
      const Reconstruction found = r.solve_without_outliers(fixes, scratch, coefficients_, 0.4);
      EXPECT_EQ(guard.allocations(), 0U);
      ASSERT_TRUE(found.determined);
      EXPECT_FALSE(fixes[i].found()) << i;
      EXPECT_EQ(fixes[i].peak, 7.0F);
      for (std::size_t k = 0; k < modes_.size(); ++k) {
        EXPECT_NEAR(coefficients_[k], truth_(k), 1e-5) << i << ", " << lost;
      }
    }
  }
}

TEST_F(Reconstruct, LosesTwoSpotsThatChangedPlaces) {
  const Reconstructor r(slopes_, modes_, reference_);
  Reconstructor::Scratch scratch = r.make_scratch();
  coefficients_.resize(modes_.size());
  auto fixes = spots(truth_);
  std::swap(fixes[9], fixes[10]);
  r.solve_without_outliers(fixes, scratch, coefficients_, 0.4);
  EXPECT_FALSE(fixes[9].found());
  EXPECT_FALSE(fixes[10].found());
  for (std::size_t k = 0; k < modes_.size(); ++k) EXPECT_NEAR(coefficients_[k], truth_(k), 1e-5);
}

TEST_F(Reconstruct, LosesNoSpotToNoiseOrToModesThatItDoesNotKnow) {
  const Reconstructor r(slopes_, modes_, reference_);
  Reconstructor::Scratch scratch = r.make_scratch();
  coefficients_.resize(modes_.size());
  std::mt19937 random(4);
  std::normal_distribution<float> off(0.0F, 2.0F);
  for (int k = 0; k < 300; ++k) {
    auto fixes = spots(truth_);
    for (SpotFix& fix : fixes) fix.x += off(random), fix.y += off(random);
    for (int i = 0; i < k % 7; ++i) fixes[(5 * i + k) % 19] = SpotFix{};
    const auto count = [&] {
      return std::count_if(fixes.begin(), fixes.end(), [](const auto& s) { return s.found(); });
    };
    const auto before = count();
    r.solve_without_outliers(fixes, scratch, coefficients_, 0.4);
    EXPECT_EQ(count(), before) << k;
  }
}

/// 12 of 19 spots leave only 6 degrees of freedom beside 18 modes: any such set agrees better
/// without its worst spot.
TEST_F(Reconstruct, LosesNoSpotWhereTooFewAreLeftToTell) {
  const Reconstructor r(slopes_, modes_, reference_);
  Reconstructor::Scratch scratch = r.make_scratch();
  coefficients_.resize(modes_.size());
  std::mt19937 random(5);
  std::normal_distribution<float> off(0.0F, 2.0F);
  int determined = 0;
  for (int k = 0; k < 100; ++k) {
    auto fixes = spots(truth_);
    for (SpotFix& fix : fixes) fix.x += off(random), fix.y += off(random);
    for (int i = 0; i < 7; ++i) fixes[std::size_t((8 * i + k) % 19)] = SpotFix{};
    const Reconstruction found = r.solve_without_outliers(fixes, scratch, coefficients_, 0.4);
    determined += found.determined ? 1 : 0;
    EXPECT_EQ(found.used, 12) << k;
    EXPECT_EQ(found.lost, 7) << k;
  }
  EXPECT_GT(determined, 20);
}

TEST_F(Reconstruct, DoesNotAllocate) {
  const Reconstructor r(slopes_, modes_, reference_);
  Reconstructor::Scratch scratch = r.make_scratch();
  std::vector<float> coefficients(modes_.size());
  const auto all = spots(truth_);
  auto some = all;
  some[2] = some[9] = SpotFix{};
  const test::AllocGuard guard;
  const bool a = r.solve(all, scratch, coefficients).determined;
  const bool b = r.solve(some, scratch, coefficients).determined;
  const auto allocations = guard.allocations();
  EXPECT_EQ(allocations, 0U);
  EXPECT_TRUE(a);
  EXPECT_TRUE(b);
}

TEST(DeterminedModes, OfNoSpotsOrNoModesAreNone) {
  EXPECT_EQ(determined_modes(Eigen::MatrixXd(0, 5)), 0);
  EXPECT_EQ(determined_modes(Eigen::MatrixXd(8, 0)), 0);
  EXPECT_EQ(determined_modes(Eigen::MatrixXd(0, 0)), 0);
}

class ReconstructLarge : public Reconstruct {
 protected:
  ReconstructLarge() : Reconstruct(15) {}
};

TEST_F(ReconstructLarge, GivesBackTheModesWithoutAllocating) {
  const Reconstructor r(slopes_, modes_, reference_);
  Reconstructor::Scratch scratch = r.make_scratch();
  std::vector<float> coefficients(modes_.size());
  auto fixes = spots(truth_);
  fixes[20] = fixes[33] = SpotFix{};
  const test::AllocGuard guard;
  const Reconstruction result = r.solve(fixes, scratch, coefficients);
  const auto allocations = guard.allocations();
  EXPECT_EQ(allocations, 0U);
  ASSERT_TRUE(result.determined);
  for (std::size_t k = 0; k < modes_.size(); ++k) {
    EXPECT_NEAR(coefficients[k], truth_(k), 1e-4) << "j = " << modes_[k];
  }
}

}  // namespace
}  // namespace ovws
