/// Surface scan against surfaces whose slopes are sums over pixels.
#include "core/wavefront/surface_scan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "core/optics/zernike.hpp"

namespace ovws {
namespace {

constexpr double kPupil = 768.0, kProbe = 0.14 * kPupil;
const PxPerCycle kTurnedScan(1100.0, 1580.0, 1600.0, -1090.0);  // and mirrored

using SlmSurface = std::function<double(Vec2)>;  // waves at SLM pixels from the pupil's centre

/// A sum of cosines of up to `cycles` over the pupil, like the twin's flatness error.
SlmSurface random_surface(unsigned seed, double cycles, double rms_waves) {
  constexpr int kWaves = 8;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  struct Wave {
    Vec2 cpp;
    double start;
  };
  std::vector<Wave> all;
  for (int k = 0; k < kWaves; ++k) {
    const double turn = 2.0 * std::numbers::pi * part(random);
    const double cpp = (0.5 + (cycles - 0.5) * part(random)) / kPupil;
    all.push_back({cpp * Vec2{std::cos(turn), std::sin(turn)}, part(random)});
  }
  return [all, rms_waves](Vec2 at) {
    double sum = 0.0;
    for (const Wave& one : all) {
      sum += std::cos(2.0 * std::numbers::pi * (one.cpp.x * at.x + one.cpp.y * at.y + one.start));
    }
    return rms_waves * std::sqrt(2.0 / kWaves) * sum;
  };
}

/// Calls `what` for every `step`-th pixel of a circle.
void for_each_pixel(Vec2 centre, double diameter, double step,
                    const std::function<void(Vec2)>& what) {
  for (double y = 0.5 * step - 0.5 * diameter; y < 0.5 * diameter; y += step) {
    for (double x = 0.5 * step - 0.5 * diameter; x < 0.5 * diameter; x += step) {
      if (std::hypot(x, y) <= 0.5 * diameter) what(centre + Vec2{x, y});
    }
  }
}

/// Positions of a bright spot's core: the best-fitting plane over the aperture (Z-tilt).
std::vector<std::optional<Vec2>> places(const ScanGrid& grid, const SlmSurface& surface,
                                        const PxPerCycle& map) {
  std::vector<std::optional<Vec2>> at;
  for (const Vec2 centre : grid.centres_px) {
    Vec2 sum;
    double square = 0.0;
    for_each_pixel(centre, grid.probe_diameter_px, 3.0, [&](Vec2 pixel) {
      const Vec2 arm = pixel - centre;
      sum = sum + surface(pixel) * arm;
      square += arm.x * arm.x;
    });
    at.push_back(Vec2{250.0, 260.0} + map * ((1.0 / square) * sum));
  }
  return at;
}

std::vector<double> modes_of(const SlmSurface& surface, const std::vector<int>& modes_j) {
  std::vector<double> waves(modes_j.size(), 0.0);
  int pixels = 0;
  for_each_pixel({}, kPupil, 4.0, [&](Vec2 pixel) {
    const Vec2 at = (2.0 / kPupil) * pixel;
    for (std::size_t k = 0; k < waves.size(); ++k) {
      waves[k] += surface(pixel) * zernike(modes_j[k], at);
    }
    ++pixels;
  });
  for (double& wave : waves) wave /= pixels;
  return waves;
}

double worst(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t k = 2; k < 18; ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

TEST(SurfaceScan, FindsTheModesOfASurfaceThatIsFinerThanTheLattice) {
  const ScanFit fit(scan_grid(kPupil, kProbe), kTurnedScan);
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const SlmSurface surface = random_surface(seed, 2.5, 0.3);
    const std::vector<double> none(fit.modes_j().size(), 0.0);
    const auto found = fit.fit(places(fit.grid(), surface, kTurnedScan), none);
    ASSERT_TRUE(found);
    EXPECT_LT(worst(found->waves, modes_of(surface, fit.modes_j())), 0.004) << seed;
    EXPECT_LT(found->residual_px, 0.6) << seed;
  }
}

TEST(SurfaceScan, TakesOffWhatWasShown) {
  const ScanFit fit(scan_grid(kPupil, kProbe), kTurnedScan);
  const SlmSurface surface = random_surface(3, 1.5, 0.2);
  const std::vector<double> none(fit.modes_j().size(), 0.0);
  const auto first = fit.fit(places(fit.grid(), surface, kTurnedScan), none);
  ASSERT_TRUE(first);
  std::vector<double> opposite = first->waves;
  for (double& wave : opposite) wave = -wave;
  const SlmSurface left = [&](Vec2 at) {
    double waves = surface(at);
    for (std::size_t k = 0; k < opposite.size(); ++k) {
      waves += opposite[k] * zernike(fit.modes_j()[k], (2.0 / kPupil) * at);
    }
    return waves;
  };
  const auto second = fit.fit(places(fit.grid(), left, kTurnedScan), opposite);
  ASSERT_TRUE(second);
  EXPECT_LT(worst(second->waves, first->waves), 0.002);
}

TEST(SurfaceScan, KnowsHowWellItKnows) {
  constexpr double kScanNoisePx = 0.2;
  constexpr int kTimes = 100;
  const ScanFit fit(scan_grid(kPupil, kProbe), kTurnedScan);
  const std::vector<double> none(fit.modes_j().size(), 0.0);
  const auto still = places(
      fit.grid(), [](Vec2) { return 0.0; }, kTurnedScan);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, kScanNoisePx);
  double error = 0.0, estimated = 0.0;
  for (int i = 0; i < kTimes; ++i) {
    auto at = still;
    for (auto& one : at) *one = *one + Vec2{noise(random), noise(random)};
    const auto found = fit.fit(at, none);
    ASSERT_TRUE(found);
    for (std::size_t k = 2; k < 18; ++k) {
      error += found->waves[k] * found->waves[k];
      estimated += found->standard_error[k] * found->standard_error[k];
    }
  }
  EXPECT_NEAR(std::sqrt(estimated / error), 1.0, 0.1);
}

TEST(SurfaceScan, DoesWithoutASpotAndNotWithoutMany) {
  const ScanFit fit(scan_grid(kPupil, kProbe), kTurnedScan);
  const SlmSurface surface = random_surface(2, 1.5, 0.2);
  const std::vector<double> none(fit.modes_j().size(), 0.0);
  auto at = places(fit.grid(), surface, kTurnedScan);
  at[7].reset();
  at[40].reset();
  const auto found = fit.fit(at, none);
  ASSERT_TRUE(found);
  EXPECT_LT(worst(found->waves, modes_of(surface, fit.modes_j())), 0.006);
  for (std::size_t k = 0; k < at.size(); k += 5) at[k].reset();
  const auto refused = fit.fit(at, none);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().reason.find("no spot"), std::string::npos);
}

TEST(SurfaceScan, AperturesLieInThePupil) {
  for (const double probe : {0.02, 0.14, 0.3}) {
    const ScanGrid grid = scan_grid(kPupil, probe * kPupil);
    EXPECT_EQ(grid.centres_px.size(), 61U);
    for (const Vec2 centre : grid.centres_px) {
      EXPECT_LE(norm(centre) + 0.5 * probe * kPupil, 0.5 * kPupil + 1e-3);
    }
  }
}

}  // namespace
}  // namespace ovws
