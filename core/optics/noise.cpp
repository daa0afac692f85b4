#include "core/optics/noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ovws {
namespace {

/// Quantiles of the normal distribution at (k + 1/2) / quantiles, scaled to a variance of exactly
/// 1/2, because Noise::normal adds two of them.
std::vector<float> make_half_normals(int quantiles) {
  std::vector<double> upper;
  double sum_of_squares = 0.0;
  double z = 0.0;
  for (int k = 0; k < quantiles / 2; ++k) {
    const double above_mean = (k + 0.5) / quantiles;
    // Newton's method from the previous quantile converges from below: the density falls with z.
    for (int step = 0; step < 6; ++step) {
      const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
      z += (above_mean - 0.5 * std::erf(z / std::numbers::sqrt2)) / density;
    }
    upper.push_back(z);
    sum_of_squares += 2.0 * z * z;
  }
  const double scale = std::sqrt(0.5 * quantiles / sum_of_squares);
  std::vector<float> normals;
  for (const double value : upper) {
    normals.push_back(static_cast<float>(scale * value));
    normals.push_back(static_cast<float>(-scale * value));
  }
  return normals;
}

/// Poisson probabilities of the counts 0, 1, … counts - 1.
std::vector<double> poisson_probabilities(double mean, int counts) {
  std::vector<double> result;
  double probability = std::exp(-mean);
  for (int count = 0; count < counts; ++count) {
    result.push_back(probability);
    probability *= mean / (count + 1.0);
  }
  return result;
}

struct Alias {
  double share = 1.0;
  int count = 0;
};

/// Columns of the alias method (Vose 1991): a column whose count is rarer than the average is
/// filled up with a more frequent count, its alias.
std::vector<Alias> alias_columns(const std::vector<double>& probabilities) {
  std::vector<Alias> columns(probabilities.size());
  std::vector<double> left(probabilities.size());
  std::vector<int> rare, frequent;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    columns[i].count = int(i);
    left[i] = probabilities[i] * double(columns.size());
    (left[i] < 1.0 ? rare : frequent).push_back(int(i));
  }
  while (!rare.empty() && !frequent.empty()) {
    const auto small = std::size_t(rare.back()), large = std::size_t(frequent.back());
    rare.pop_back();
    columns[small] = {left[small], int(large)};
    left[large] -= 1.0 - left[small];
    if (left[large] >= 1.0) continue;
    frequent.pop_back();
    rare.push_back(int(large));
  }
  return columns;
}

}  // namespace

Noise::Tables::Tables() : half_normals(make_half_normals(1 << kQuantileBits)) {
  constexpr int kMeans = kPerElectron * static_cast<int>(kExactPoisson);
  constexpr std::uint32_t kCounts = 1U << Column::kCountBits;
  constexpr std::uint32_t kWhole = (1U << Column::kShareBits) - 1;
  for (int k = 0; k < kMeans; ++k) {
    const double mean = static_cast<double>(k) / kPerElectron;
    for (const Alias& alias : alias_columns(poisson_probabilities(mean, int(kCounts)))) {
      const auto share = std::uint32_t(std::lround(std::clamp(alias.share, 0.0, 1.0) * kWhole));
      const std::uint32_t bits = (share & kWhole) | std::uint32_t(alias.count)
                                                        << Column::kShareBits;
      poisson.push_back(std::int32_t(bits));
    }
  }
}

const Noise::Tables& Noise::tables() {
  static const Tables tables;
  return tables;
}

}  // namespace ovws
