/// The phase of the modes against the sum in long double, and the loops for every instruction set.
#include "core/optics/hologram_row.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "core/optics/circle_columns.hpp"
#include "core/optics/hologram.hpp"
#include "core/optics/phasors.hpp"
#include "core/optics/wavefront_rows.hpp"
#include "core/optics/zernike_terms.hpp"
#include "tests/support/every_target.hpp"

namespace ovws {
namespace {

/// Waves: a pixel may round to the wrong side if it is closer than this to a tie.
constexpr double kPhaseError = 1.0 / 65536.0 / 1024.0;

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
struct SlmGrid {
  int width, height;
  double diameter;
  Vec2 centre() const { return {0.5 * (width - 1), 0.5 * (height - 1)}; }
};

/// Phase of row y, all columns.
std::vector<std::uint16_t> phase_of_row(const SlmGrid& grid, std::span<const Mode> modes, int y) {
  const WavefrontRows rows(modes, grid.centre(), grid.diameter);
  const int right = int(std::ceil(grid.centre().x)), left = int(std::floor(grid.centre().x));
  std::vector<double> x(std::size_t(grid.width) + kSparePixels);
  for (std::size_t k = 0; k < x.size(); ++k) {
    x[k] = (right + double(k) - grid.centre().x) / rows.radius_px();
  }
  WavefrontRows::Polynomial along_row;
  rows.along_row(y, along_row);
  std::vector<std::uint16_t> phase(std::size_t(grid.width) + 2 * kSparePixels);
  std::uint16_t* const first = phase.data() + kSparePixels;
  mirrored_phases(along_row, x.data(), grid.width - right, first + right, first + left);
  return {first, first + grid.width};
}

struct Outcome {
  std::int64_t pixels = 0;
  std::int64_t differ = 0;  ///< from the nearest step
  double worst = 0.0;       ///< of those that differ, the distance from the tie, waves
};

/// Requires that a pixel that differs takes the tie's other side.
Outcome compare(const SlmGrid& grid, std::span<const Mode> modes) {
  const long double radius = 0.5L * grid.diameter;
  Outcome outcome;
  for (int y = 0; y < grid.height; y += 1 + grid.height / 40) {
    const Columns columns = columns_in_circle(grid.centre(), grid.diameter, y, grid.width);
    const std::vector<std::uint16_t> phase = phase_of_row(grid, modes, y);
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

TEST(MirroredPhases, RoundToTheNearestStepButNextToATie) {
  for (const SlmGrid& grid :
       {SlmGrid{1280, 768, 768}, SlmGrid{1919, 1080, 1080}, SlmGrid{3840, 2160, 2160},
        SlmGrid{641, 479, 300}, SlmGrid{33, 20, 20}, SlmGrid{1, 300, 300}}) {
    for (unsigned seed = 0; seed < 3; ++seed) {
      const Outcome outcome = compare(grid, random_modes(18, 1.0, seed));
      EXPECT_LT(outcome.worst, kPhaseError) << grid.width;
      EXPECT_LE(outcome.differ, outcome.pixels / 100000) << grid.width;
    }
  }
}

TEST(MirroredPhases, HoldTheBoundForHighOrders) {
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

TEST(MirroredPhases, HoldTheBoundForLargeCoefficients) {
  const Outcome outcome =
      compare({1280, 768, 768}, std::vector<Mode>{{0, 1e6}, {1, -1e6}, {2, 1e6}, {4, 1e5}});
  EXPECT_LT(outcome.worst, kPhaseError);
  EXPECT_LE(outcome.differ, outcome.pixels / 1000);
}

TEST(MirroredPhases, TakeTiesToEven) {
  for (const double waves : {0.5 / 65536.0, 1.5 / 65536.0, -0.5 / 65536.0, -1e6 - 0.5 / 65536.0}) {
    const auto even = std::uint16_t(std::llround(std::nearbyint(waves * 65536.0)));
    EXPECT_EQ(phase16(waves), even);
    for (const std::uint16_t phase : phase_of_row({40, 2, 60}, std::vector<Mode>{{0, waves}}, 1)) {
      EXPECT_EQ(phase, even);
    }
  }
}

TEST(MirroredPhases, AreTheSameForEveryInstructionSet) {
  for (const int last : {0, 1, 2, 5, 18, 44, kMaxZernikeIndex}) {
    const auto modes = random_modes(last, 2.0, 11);
    for (const int width : {1, 2, 33, 640, 1279, 1280}) {
      const SlmGrid grid{width, 768, 768};
      const auto fastest = phase_of_row(grid, modes, 300);
      test::with_every_target([&] { EXPECT_EQ(phase_of_row(grid, modes, 300), fastest) << last; });
    }
  }
}

TEST(LookUpGreys, TakesTheLutsForEveryInstructionSetAndWidth) {
  std::mt19937 random(12);
  std::vector<std::uint16_t> base(70000), added(70000);
  for (std::size_t i = 0; i < base.size(); ++i) {
    base[i] = static_cast<std::uint16_t>(i);
    added[i] = static_cast<std::uint16_t>(random());
  }
  PhaseLut lut;
  for (auto& level : lut) level = static_cast<std::uint8_t>(random());
  test::with_every_target([&] {
    for (const int count : {0, 1, 7, 31, 32, 33, 63, 64, 65, 127, 641, 70000}) {
      std::vector<std::uint8_t> grey(count + 1, 77);
      look_up_greys(base.data(), added.data(), lut.data(), count, grey.data());
      for (int i = 0; i < count; ++i) {
        ASSERT_EQ(grey[i], lut[std::uint16_t(base[i] + added[i]) >> 8]) << count;
      }
      EXPECT_EQ(grey[count], 77);
    }
  });
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
