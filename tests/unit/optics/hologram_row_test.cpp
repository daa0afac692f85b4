/// The modes' phase in fixed point against the sum in long double, and the loops in every build.
#include "core/optics/hologram_row.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "core/optics/hologram.hpp"
#include "core/optics/phase_rows.hpp"
#include "core/optics/zernike_terms.hpp"

namespace ovws {
namespace {

/// The sum of the modes, waves, at (x, y) pupil radii.
long double truth(std::span<const Mode> modes, long double x, long double y) {
  long double sum = 0.0L;
  for (const Mode& mode : modes) {
    const ZernikeTerms& terms = zernike_terms(mode.j);
    long double radial = 0.0L;
    for (int k = terms.count; k-- > 0;) radial = radial * (x * x + y * y) + terms.radial[k];
    long double re = 1.0L, im = 0.0L;
    for (int k = 0; k < std::abs(terms.m); ++k) {
      const long double turned = re * x - im * y;
      im = re * y + im * x;
      re = turned;
    }
    sum += mode.waves * radial * (terms.m < 0 ? im : re);
  }
  return sum;
}

std::vector<Mode> random_modes(int last, double most, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution waves(-most, most);
  std::vector<Mode> modes;
  for (int j = 1; j <= last; ++j) modes.push_back({j, waves(random)});
  return modes;
}

/// A grid with the pupil in its middle.
struct Grid {
  int width, height;
  double diameter;
  Vec2 centre() const { return {0.5 * (width - 1), 0.5 * (height - 1)}; }
  PhaseRows rows(std::span<const Mode> modes) const {
    return {modes, centre(), diameter, width, height};
  }
};

struct Outcome {
  std::int64_t pixels = 0;
  std::int64_t differ = 0;  ///< from the nearest step
  double worst = 0.0;       ///< of those that differ, the distance from the tie, waves
};

/// Requires that a pixel that differs takes the tie's other side.
Outcome compare(const Grid& grid, std::span<const Mode> modes) {
  const PhaseRows rows = grid.rows(modes);
  EXPECT_TRUE(rows.in_fixed_point());
  std::vector<std::uint16_t> phase(rows.row_size());
  std::vector<double> waves(grid.width);
  const long double radius = 0.5L * grid.diameter;
  Outcome outcome;
  for (int y = 0; y < grid.height; y += 1 + grid.height / 40) {
    const Columns columns = rows.row(y, hologram_row_kernels().back(), phase, waves);
    for (int x = columns.begin; x < columns.end; ++x, ++outcome.pixels) {
      const long double steps =
          65536.0L * truth(modes, (x - grid.centre().x) / radius, (y - grid.centre().y) / radius);
      const long double nearest = std::floor(steps + 0.5L);
      const auto error =
          static_cast<std::int16_t>(phase[x] - static_cast<std::uint16_t>(std::int64_t(nearest)));
      if (error == 0) continue;
      ++outcome.differ;
      EXPECT_EQ(error, steps > nearest ? 1 : -1) << x << ' ' << y;
      outcome.worst = std::max(outcome.worst, double(0.5L - std::abs(steps - nearest)) / 65536.0);
    }
  }
  return outcome;
}

TEST(PhaseRows, RoundToTheNearestStepButNextToATie) {
  for (const Grid& grid : {Grid{1280, 768, 768}, Grid{1919, 1080, 1080}, Grid{3840, 2160, 2160},
                           Grid{641, 479, 300}, Grid{33, 20, 20}, Grid{1, 300, 300}}) {
    for (unsigned seed = 0; seed < 3; ++seed) {
      const Outcome outcome = compare(grid, random_modes(18, 1.0, seed));
      EXPECT_LT(outcome.worst, kPhaseError) << grid.width;
      EXPECT_LE(outcome.differ, outcome.pixels / 100000) << grid.width;
    }
  }
}

TEST(PhaseRows, HoldTheBoundForHighOrders) {
  for (const int last : {27, 44, 65, 90}) {
    const double most = last == 90 ? 0.05 : 1.0;
    const Outcome outcome = compare({1280, 768, 768}, random_modes(last, most, 5));
    EXPECT_LT(outcome.worst, kPhaseError) << last;
    EXPECT_LE(outcome.differ, outcome.pixels / 1000) << last;
  }
  // All 231 where the grid does not leave the pupil.
  const Outcome outcome = compare({301, 203, 1600}, random_modes(kMaxZernikeIndex, 1.0, 6));
  EXPECT_LT(outcome.worst, kPhaseError);
  EXPECT_LE(outcome.differ, outcome.pixels / 1000);
}

TEST(PhaseRows, HoldTheBoundForLargeCoefficients) {
  const Outcome outcome =
      compare({1280, 768, 768}, std::vector<Mode>{{0, 1e6}, {1, -1e6}, {2, 1e6}, {4, 1e5}});
  EXPECT_LT(outcome.worst, kPhaseError);
  EXPECT_LE(outcome.differ, outcome.pixels / 1000);
}

TEST(PhaseRows, HoldTheBoundForTheStrongestModesTheyTake) {
  for (const int last : {2, 5, 9, 18, 65}) {
    const Grid grid{1280, 768, 768};
    double most = 1e9;
    while (!grid.rows(random_modes(last, most, 9)).in_fixed_point()) most *= 0.8;
    const Outcome outcome = compare(grid, random_modes(last, most, 9));
    EXPECT_LT(outcome.worst, kPhaseError) << last;
    EXPECT_LE(outcome.differ, outcome.pixels / 1000) << last;
  }
}

TEST(PhaseRows, TakeTiesUpwards) {
  const Grid grid{40, 2, 60};
  for (const double waves : {0.5 / 65536.0, 1.5 / 65536.0, -0.5 / 65536.0, -1e6 - 0.5 / 65536.0}) {
    const PhaseRows rows = grid.rows(std::vector<Mode>{{0, waves}});
    std::vector<std::uint16_t> phase(rows.row_size());
    std::vector<double> memory(40);
    rows.row(1, hologram_row_kernels().back(), phase, memory);
    for (int x = 0; x < 40; ++x) {
      EXPECT_EQ(phase[x], std::uint16_t(std::llround(std::floor(waves * 65536.0 + 0.5))));
    }
  }
}

TEST(PhaseRows, LeaveWhatTheyCannotResolveToTheDoubleSum) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const Grid grid{1279, 768, 768};
  for (const auto& modes :
       {random_modes(kMaxZernikeIndex, 0.1, 8), std::vector<Mode>{{kMaxZernikeIndex, 1e6}},
        std::vector<Mode>{{0, 1e300}}, std::vector<Mode>{{3, kNone}}}) {
    const PhaseRows rows = grid.rows(modes);
    EXPECT_FALSE(rows.in_fixed_point());
    std::vector<std::uint16_t> phase(rows.row_size());
    std::vector<double> memory(grid.width), waves(grid.width);
    const Columns columns = rows.row(300, hologram_row_kernels().back(), phase, memory);
    const std::span<double> shown(&waves[columns.begin], columns.end - columns.begin);
    WavefrontRows(modes, grid.centre(), grid.diameter).waves(300, columns.begin, shown);
    for (int x = columns.begin; x < columns.end; ++x) EXPECT_EQ(phase[x], phase16(waves[x]));
  }
}

TEST(PhaseRows, AreThoseOfThePupil) {
  for (const Grid& grid : {Grid{641, 479, 300}, Grid{300, 641, 479}, Grid{1280, 768, 768}}) {
    const auto modes = random_modes(18, 1.0, 4);
    const PhaseRows rows = grid.rows(modes);
    std::vector<std::uint16_t> phase(rows.row_size());
    std::vector<double> memory(grid.width);
    for (int y = 0; y < grid.height; ++y) {
      const Columns columns = rows.row(y, hologram_row_kernels().back(), phase, memory);
      for (int x = 0; x < grid.width; ++x) {
        const bool shown = x >= columns.begin && x < columns.end;
        ASSERT_EQ(shown, norm(Vec2{double(x), double(y)} - grid.centre()) <= 0.5 * grid.diameter)
            << x << ' ' << y;
      }
    }
  }
}

TEST(HologramRowKernels, PhasesAreTheSameInEveryBuild) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> waves(-1.0, 1.0);
  for (int degree = 0; degree <= kMaxPhaseDegree; ++degree) {
    std::vector<double> terms;
    for (int k = 0; k <= degree; ++k) {
      const double size = std::pow(10.0, 6 - 12 * k / (degree + 1));
      for (int i = 0; i < (degree - k + 1) * kPhaseLanes; ++i)
        terms.push_back(size * waves(random));
    }
    for (const int steps : {1, 2, 79, 80}) {
      const auto phases = [&](const HologramRowKernels& kernels) {
        std::vector<std::uint16_t> phase((steps + kSpareSteps) * kPhaseLanes + 1, 0xABCD);
        kernels.phases(terms.data(), degree, 0.7123, steps, phase.data());
        EXPECT_EQ(phase.back(), 0xABCD);
        phase.resize(steps * kPhaseLanes);
        return phase;
      };
      const auto plain = phases(hologram_row_kernels().front());
      for (const HologramRowKernels& kernels : hologram_row_kernels()) {
        EXPECT_EQ(phases(kernels), plain) << kernels.name << ' ' << degree << ' ' << steps;
      }
    }
  }
}

TEST(HologramRowKernels, GreysAreTheLutsInEveryBuildAndWidth) {
  std::mt19937 random(12);
  std::vector<std::uint16_t> base(70000), added(70000);
  for (std::size_t i = 0; i < base.size(); ++i) {
    base[i] = static_cast<std::uint16_t>(i);
    added[i] = static_cast<std::uint16_t>(random());
  }
  PhaseLut lut;
  for (auto& level : lut) level = static_cast<std::uint8_t>(random());
  for (const HologramRowKernels& kernels : hologram_row_kernels()) {
    for (const int count : {0, 1, 7, 31, 32, 33, 63, 64, 65, 127, 641, 70000}) {
      std::vector<std::uint8_t> grey(count + 1, 77);
      kernels.greys(base.data(), added.data(), lut.data(), count, grey.data());
      for (int i = 0; i < count; ++i) {
        ASSERT_EQ(grey[i], lut[std::uint16_t(base[i] + added[i]) >> 8]) << kernels.name;
      }
      EXPECT_EQ(grey[count], 77) << kernels.name;
    }
  }
}

TEST(Hologram, OfOddWidthShowsModesOnFlatnessThroughTheLut) {
  HologramConfig config;
  config.slm.width_px = 1279;
  config.slm.height_px = 767;
  config.sensor.grooves = {0.0, 0.0};
  config.sensor.pupil_diameter_px = 767;
  auto flatness = std::make_shared<Image<float>>(1279, 767);
  for (std::size_t i = 0; i < flatness->pixels.size(); ++i) {
    flatness->pixels[i] = float(i % 1013) / 1013.0F;
  }
  config.flatness_waves = flatness;
  for (int k = 0; k < 256; ++k) config.lut[k] = static_cast<std::uint8_t>((k * k) / 300);
  const auto modes = random_modes(18, 0.5, 3);
  Image<std::uint8_t> grey;
  HologramRenderer::make(config).value().render(HologramKind::grating, modes, grey);
  const double radius = 0.5 * config.sensor.pupil_diameter_px;
  int differ = 0;
  for (int y = 0; y < 767; y += 9) {
    for (int x = 0; x < 1279; ++x) {
      const bool in_pupil = norm(Vec2{x - 639.0, y - 383.0}) <= radius;
      const long double waves =
          in_pupil ? truth(modes, (x - 639.0L) / radius, (y - 383.0L) / radius) : 0.0L;
      const auto added = std::floor(65536.0L * waves + 0.5L);
      const auto phase = static_cast<std::uint16_t>(phase16(flatness->at(x, y)) +
                                                    static_cast<std::int64_t>(added));
      differ += grey.at(x, y) != config.lut[phase >> 8];
    }
  }
  EXPECT_EQ(differ, 0);
}

}  // namespace
}  // namespace ovws
