/// Branch points are recognised by the circulation of simulated tilts.
#include "core/wavefront/branch_points.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "core/wavefront/reconstructor.hpp"
#include "core/wavefront/slope_model.hpp"
#include "tests/support/alloc_guard.hpp"

namespace ovws {
namespace {

const PxPerCycle kMap{1900.0, 300.0, -250.0, 1850.0};

struct Singularity {
  Vec2 at;  ///< pupil radii
  int charge = 1;
};

/// A sensor whose spots move as the tilts of its subapertures.
class Tilts {
 public:
  explicit Tilts(Grid grid, int across) {
    sensor_.grid = grid;
    sensor_.subapertures_across = across;
    lattice_ = make_lattice(sensor_, {}).value();
    modes_.resize(std::size_t(across == 5 ? 18 : 25));
    std::iota(modes_.begin(), modes_.end(), 1);
    slopes_ = slope_matrix(lattice_, sensor_, modes_, kGradientTilt, kMap);
    const std::vector<Vec2> reference(lattice_.subapertures.size());
    reconstructor_.emplace(slopes_, modes_, reference);
    scratch_ = reconstructor_->make_scratch();
    points_.emplace(lattice_, radius(), kMap);
  }

  double radius() const { return 0.5 * sensor_.pupil_diameter_px; }
  double lambda_d_px() const { return kMap.scale() / lattice_.diameter_px; }
  double pitch() const { return lattice_.diameter_px / radius(); }

  /// The mean gradient of a singularity outside a subaperture is that at its centre. The spot of a
  /// subaperture that contains it is lost.
  std::vector<SpotFix> spots(const std::vector<Singularity>& all, double noise_px = 0.0) {
    std::vector<SpotFix> fixes;
    for (const Subaperture& one : lattice_.subapertures) {
      Vec2 slope;
      bool lost = false;
      for (const Singularity& s : all) {
        const Vec2 r = one.centre_px - radius() * s.at;
        const double square = r.x * r.x + r.y * r.y;
        lost = lost || std::sqrt(square) < 0.5 * lattice_.diameter_px;
        slope = slope + s.charge / (2.0 * std::numbers::pi * square) * Vec2{-r.y, r.x};
      }
      const Vec2 at = kMap * slope;
      fixes.push_back(lost ? SpotFix{}
                           : SpotFix{float(at.x + noise_px * gauss_(random_)),
                                     float(at.y + noise_px * gauss_(random_)), 1.0F, 1.0F});
    }
    return fixes;
  }
  void add(std::vector<SpotFix>& fixes, int j, double waves) const {
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      fixes[i].x += float(waves * slopes_(2 * Eigen::Index(i), j - 1));
      fixes[i].y += float(waves * slopes_(2 * Eigen::Index(i) + 1, j - 1));
    }
  }

  std::vector<BranchPoint> find(const std::vector<SpotFix>& fixes, int outlier = -1) {
    std::vector<float> waves(modes_.size());
    std::vector<Vec2> left(fixes.size());
    std::array<BranchPoint, kMaxBranchPoints> found;
    EXPECT_TRUE(reconstructor_->solve(fixes, scratch_, waves).determined);
    reconstructor_->residuals(fixes, scratch_, left);
    const test::AllocGuard guard;
    const int count = points_->find(left, outlier, found);
    EXPECT_EQ(guard.allocations(), 0U);
    return {found.begin(), found.begin() + count};
  }

 private:
  SensorConfig sensor_;
  Lattice lattice_;
  std::vector<int> modes_;
  Eigen::MatrixXd slopes_;
  std::optional<Reconstructor> reconstructor_;
  Reconstructor::Scratch scratch_;
  std::optional<BranchPoints> points_;
  std::mt19937 random_{1};
  std::normal_distribution<double> gauss_;
};

TEST(BranchPoints, ASingleOneIsFoundWithPlaceAndSign) {
  for (const Grid grid : {Grid::hexagonal, Grid::square}) {
    Tilts tilts(grid, grid == Grid::hexagonal ? 5 : 6);
    for (int k = 0; k < 24; ++k) {
      const double angle = k * std::numbers::pi / 12.0;
      const Singularity truth{{0.3 * std::cos(angle), 0.3 * std::sin(angle)}, k % 2 == 0 ? 1 : -1};
      const auto found = tilts.find(tilts.spots({truth}, 0.01 * tilts.lambda_d_px()));
      ASSERT_GE(found.size(), 1U) << int(grid) << " " << k;
      EXPECT_EQ(found[0].charge, truth.charge) << k;
      EXPECT_LT(norm(found[0].at - truth.at), tilts.pitch()) << k;
    }
  }
}

TEST(BranchPoints, APairIsFoundOneSubapertureApart) {
  Tilts tilts(Grid::hexagonal, 5);
  const auto found = tilts.find(tilts.spots({{{-0.3, 0.0}, 1}, {{0.3, 0.0}, -1}}));
  ASSERT_GE(found.size(), 1U);
  for (const BranchPoint& one : found) EXPECT_EQ(one.charge, one.at.x < 0.0 ? 1 : -1);
}

TEST(BranchPoints, NoiseAloneGivesNoneIn10000Frames) {
  Tilts tilts(Grid::hexagonal, 5);
  for (int frame = 0; frame < 10000; ++frame) {
    ASSERT_TRUE(tilts.find(tilts.spots({}, 0.03 * tilts.lambda_d_px())).empty()) << frame;
  }
}

TEST(BranchPoints, StrongModesGiveNone) {
  Tilts tilts(Grid::hexagonal, 5);
  for (int j = 1; j <= 18; ++j) {
    auto fixes = tilts.spots({}, 0.01 * tilts.lambda_d_px());
    tilts.add(fixes, j, 2.0);
    EXPECT_TRUE(tilts.find(fixes).empty()) << j;
  }
}

TEST(BranchPoints, ASpotAsideGivesNone) {
  Tilts tilts(Grid::hexagonal, 5);
  for (std::size_t i = 0; i < 19; ++i) {
    auto fixes = tilts.spots({});
    fixes[i].x += float(tilts.lambda_d_px());
    EXPECT_TRUE(tilts.find(fixes, int(i)).empty()) << i;
  }
}

}  // namespace
}  // namespace ovws
