// SIMD pixel kernels against plain sums in double, for every available instruction set and for rows
// that are not a multiple of the block.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "core/tracking/patch_kernels.hpp"
#include "tests/support/every_target.hpp"

namespace ovws {
namespace {

constexpr int kRows = 7;

struct PatchLoops : testing::TestWithParam<int> {
  int columns = GetParam();
  std::mt19937 random{unsigned(GetParam())};

  template <class Pixel>
  std::vector<Pixel> pixels(int stride) {
    std::uniform_int_distribution<int> any(5, std::numeric_limits<Pixel>::max());
    std::vector<Pixel> made(std::size_t(kRows * stride));
    for (Pixel& p : made) p = Pixel(any(random));
    return made;
  }

  std::vector<float> floats() {
    std::uniform_real_distribution<float> any(0.0F, 4000.0F);
    std::vector<float> made(std::size_t(kRows * columns + kPatchBlock));
    for (float& v : made) v = any(random);
    return made;
  }

  template <class Pixel>
  void expect_loaded(float (*load)(const PixelRect&, float*)) {
    const int stride = columns + 3;  // pixels beside the rectangle must not count
    std::vector<Pixel> made = pixels<Pixel>(stride);
    for (int y = 0; y < kRows; ++y) {
      std::fill_n(made.begin() + y * stride + columns, 3, Pixel(0));
    }
    const PixelRect rect{reinterpret_cast<const std::byte*>(made.data()),
                         std::ptrdiff_t(stride * sizeof(Pixel)), columns, kRows};
    std::vector<float> out(std::size_t(kRows * columns));
    for (const int dark : {0, columns / 2, columns - 1}) {
      const auto at = std::size_t(3 * stride + dark);
      const Pixel before = std::exchange(made[at], Pixel(2));
      EXPECT_EQ(load(rect, out.data()), 2.0F) << "darkest at " << dark;
      made[at] = before;
    }
    load(rect, out.data());
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < columns; ++x) {
        ASSERT_EQ(out[std::size_t(y * columns + x)], float(made[std::size_t(y * stride + x)]));
      }
    }
  }
};

TEST_P(PatchLoops, LoadEveryPixelAndReturnTheDarkest) {
  test::with_every_target([&] {
    expect_loaded<std::uint8_t>(load8);
    expect_loaded<std::uint16_t>(load16);
  });
}

TEST_P(PatchLoops, FindTheBrightestWhereverItIs) {
  std::vector<float> values = floats();
  test::with_every_target([&] {
    for (const int bright : {0, columns / 2, columns - 1}) {
      float& value = values[std::size_t(2 * columns + bright)];
      const float before = std::exchange(value, 5000.0F);
      EXPECT_EQ(brightest({values.data(), columns, columns, kRows}), 5000.0F) << "at " << bright;
      value = before;
    }
  });
}

TEST_P(PatchLoops, SumFourthDifferencesOfWholeRowsOnly) {
  const std::vector<float> values = floats();
  double truth = 0.0;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x + 4 < columns; ++x) {
      const float* at = values.data() + y * columns + x;
      truth += std::pow(double(at[0]) - 4.0 * double(at[1]) + 6.0 * double(at[2]) -
                            4.0 * double(at[3]) + double(at[4]),
                        2);
    }
  }
  test::with_every_target([&] {
    const float squares = fourth_differences({values.data(), columns, columns, kRows});
    EXPECT_NEAR(double(squares) / truth, 1.0, 1e-5);
  });
}

TEST_P(PatchLoops, SumUnderAGaussian) {
  const int padded = (columns + kPatchBlock - 1) / kPatchBlock * kPatchBlock;
  const std::vector<float> values = floats();
  const double w = 0.17 * columns, f = 0.3, half = 0.5 * (columns - 1);
  std::vector<float> table(std::size_t(padded), 0.0F);
  for (int k = 0; k < columns; ++k) table[k] = float(std::exp(-std::pow((k - half) / w, 2)));
  const GaussianAxis from{table.data(), padded, float(std::exp(-f * (f + 2.0 * half) / (w * w))),
                          float(std::exp(2.0 * f / (w * w))), float(-half - f)};
  WindowSums truth;
  double sum = 0.0;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const double dx = x - half - f, dy = y - half - f;
      const double g = std::exp(-(dx * dx + dy * dy) / (w * w));
      const double v = g * double(values[std::size_t(y * columns + x)]);
      truth.one += float(v);
      truth.x += float(dx * v);
      truth.yy += float(dy * dy * v);
    }
  }
  for (int x = 0; x < columns; ++x) sum += std::exp(-std::pow((x - half - f) / w, 2));
  test::with_every_target([&] {
    std::vector<float> g(std::size_t(3 * padded));
    EXPECT_NEAR(double(gaussian_axis(from, g.data(), g.data() + padded, g.data() + 2 * padded)),
                sum, 1e-5 * sum);
    const WindowAxis axis{g.data(), g.data() + padded, g.data() + 2 * padded, columns, padded};
    WindowAxis down = axis;
    down.count = kRows;
    const WindowSums sums = window_sums(values.data(), columns, axis, down);
    EXPECT_NEAR(sums.one, truth.one, 1e-5 * truth.one);
    EXPECT_NEAR(sums.x, truth.x, 1e-5 * truth.one * float(half));
    EXPECT_NEAR(sums.yy, truth.yy, 1e-5 * truth.yy);
  });
}

INSTANTIATE_TEST_SUITE_P(Columns, PatchLoops, testing::Values(20, 21, 31, 32, 33, 49, 91));

}  // namespace
}  // namespace ovws
