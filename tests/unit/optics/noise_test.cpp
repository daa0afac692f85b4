/// The random numbers against the distributions that they claim.
#include "core/optics/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

namespace ovws {
namespace {

constexpr int kDraws = 1000000;

template <class Draw>
std::vector<double> draws(Draw draw) {
  std::vector<double> values;
  for (int i = 0; i < kDraws; ++i) values.push_back(static_cast<double>(draw()));
  return values;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double central_moment(const std::vector<double>& values, int power) {
  const double mean = mean_of(values);
  double sum = 0.0;
  for (const double v : values) sum += std::pow(v - mean, power);
  return sum / static_cast<double>(values.size());
}

// Bounds below are five standard errors of the statistic in question.
const double kRoot = std::sqrt(static_cast<double>(kDraws));

TEST(Noise, NormalHasTheMomentsOfANormal) {
  Noise noise(1, 0);
  const auto values = draws([&] { return noise.normal(); });
  EXPECT_NEAR(mean_of(values), 0.0, 5.0 / kRoot);
  EXPECT_NEAR(central_moment(values, 2), 1.0, 5.0 * std::sqrt(2.0) / kRoot);
  EXPECT_NEAR(central_moment(values, 3), 0.0, 5.0 * std::sqrt(15.0) / kRoot);
  EXPECT_NEAR(central_moment(values, 4), 3.0, 5.0 * std::sqrt(96.0) / kRoot);
}

TEST(Noise, NormalHasTheTailsOfANormal) {
  Noise noise(2, 0);
  std::map<int, int> beyond;
  for (int i = 0; i < kDraws; ++i) {
    const double z = static_cast<double>(noise.normal());
    for (int sigma = -3; sigma <= 3; ++sigma) beyond[sigma] += z > sigma;
  }
  for (const auto& [sigma, count] : beyond) {
    const double p = 0.5 * std::erfc(sigma / std::sqrt(2.0));
    EXPECT_NEAR(count, kDraws * p, 5.0 * std::sqrt(kDraws * p * (1.0 - p)) + 40.0) << sigma;
  }
}

TEST(Noise, NeighbouringDrawsAndStreamsAreIndependent) {
  Noise noise(3, 0);
  Noise other(3, 1);
  Noise seeded(4, 0);
  double last = static_cast<double>(noise.normal());
  double neighbours = 0.0;
  double streams = 0.0;
  double seeds = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double now = static_cast<double>(noise.normal());
    neighbours += now * last;
    streams += now * static_cast<double>(other.normal());
    seeds += now * static_cast<double>(seeded.normal());
    last = now;
  }
  EXPECT_NEAR(neighbours / kDraws, 0.0, 5.0 / kRoot);
  EXPECT_NEAR(streams / kDraws, 0.0, 5.0 / kRoot);
  EXPECT_NEAR(seeds / kDraws, 0.0, 5.0 / kRoot);
}

TEST(Noise, PoissonHasMeanAndVarianceOfItsMean) {
  for (const float mean : {0.001F, 0.1F, 0.9F, 1.0F, 7.77F, 29.99F, 30.0F, 500.0F, 20000.0F}) {
    Noise noise(5, 0);
    const auto values = draws([&] { return noise.poisson(mean); });
    const double m = static_cast<double>(mean);
    EXPECT_NEAR(mean_of(values), m, 5.0 * std::sqrt(m) / kRoot) << mean;
    // The variance of a Poisson sample's variance: (m + 2 m^2) / N.
    EXPECT_NEAR(central_moment(values, 2), m, 5.0 * std::sqrt(m + 2.0 * m * m) / kRoot) << mean;
  }
}

TEST(Noise, PoissonCountsAreExactlyPoissonUpToThirty) {
  for (const float mean : {0.03F, 0.7F, 3.06F, 12.49F, 29.9F}) {
    Noise noise(6, 0);
    std::map<int, int> counts;
    for (int i = 0; i < kDraws; ++i) ++counts[static_cast<int>(noise.poisson(mean))];
    double probability = std::exp(-static_cast<double>(mean));
    for (int k = 0; k < 80; ++k) {
      const double expected = kDraws * probability;
      if (expected > 20.0) {
        EXPECT_NEAR(counts[k], expected, 5.0 * std::sqrt(expected)) << mean << ' ' << k;
      }
      probability *= static_cast<double>(mean) / (k + 1);
    }
  }
}

TEST(Noise, PoissonOfNothingIsNothing) {
  Noise noise(7, 0);
  EXPECT_EQ(noise.poisson(0.0F), 0.0F);
  EXPECT_EQ(noise.poisson(-3.0F), 0.0F);
  EXPECT_EQ(noise.poisson(std::nanf("")), 0.0F);
}

}  // namespace
}  // namespace ovws
