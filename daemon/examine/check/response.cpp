#include "daemon/examine/check/measured.hpp"

#include <algorithm>
#include <cmath>

namespace ovws::examine {
namespace {

study::Mean mean_of_mode(const std::vector<Frame>& frames, std::size_t mode) {
  std::vector<double> values;
  values.reserve(frames.size());
  for (const Frame& frame : frames) values.push_back(frame.waves[mode]);
  return study::mean_of(values);
}

double distance(const Frame& frame, const std::vector<study::Mean>& means) {
  double sum = 0.0;
  for (std::size_t k = 0; k < means.size(); ++k) {
    sum += std::pow(frame.waves[k] - means[k].value, 2);
  }
  return std::sqrt(sum);
}

double squared(double value) {
  return value * value;
}

}  // namespace

Poke poke_of(int j, const std::array<Shown, 4>& shown) {
  Poke poke;
  poke.j = j;
  for (const Shown& one : shown) {
    poke.settled += one.settled;
    poke.valid += one.valid;
  }
  if (std::ranges::any_of(shown, [](const Shown& one) { return one.rest.empty(); })) return poke;
  const std::size_t modes = shown[0].rest[0].waves.size();
  std::array<std::vector<study::Mean>, 4> means;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    for (std::size_t k = 0; k < modes; ++k) means[i].push_back(mean_of_mode(shown[i].rest, k));
    poke.first_error_waves += 0.25 * distance(shown[i].first, means[i]);
  }
  for (std::size_t k = 0; k < modes; ++k) {
    const double first = (means[0][k].value - means[1][k].value) / (2.0 * kPokeWaves);
    const double second = (means[3][k].value - means[2][k].value) / (2.0 * kPokeWaves);
    double variance = 0.0;
    for (const auto& of_mode : means) variance += squared(of_mode[k].standard_error);
    const double by_scatter = std::sqrt(variance) / (4.0 * kPokeWaves);
    poke.gain.push_back({0.5 * (first + second),
                         std::max(by_scatter, 0.5 * std::abs(first - second)),
                         4 * shown[0].rest.size()});
  }
  poke.read = true;
  return poke;
}

double error_waves(const Poke& poke, const std::vector<int>& modes_j) {
  double sum = 0.0;
  for (std::size_t k = 0; k < poke.gain.size(); ++k) {
    const double error = poke.gain[k].value - (modes_j[k] == poke.j ? 1.0 : 0.0);
    sum += std::max(0.0, squared(error) - squared(poke.gain[k].standard_error));
  }
  return kPokeWaves * std::sqrt(sum);
}

study::Mean slope_of(const Poke& poke, const std::vector<int>& modes_j) {
  for (std::size_t k = 0; k < poke.gain.size(); ++k) {
    if (modes_j[k] == poke.j) return poke.gain[k];
  }
  return {};
}

double crosstalk_of(const Poke& poke, const std::vector<int>& modes_j) {
  double sum = 0.0;
  for (std::size_t k = 0; k < poke.gain.size(); ++k) {
    if (modes_j[k] != poke.j) sum += squared(poke.gain[k].value);
  }
  return std::sqrt(sum);
}

}  // namespace ovws::examine
