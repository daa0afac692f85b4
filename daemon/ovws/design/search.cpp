#include "daemon/ovws/design/search.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <vector>

#include "core/optics/zernike.hpp"
#include "daemon/ovws/design/attempt.hpp"
#include "proto/limits.hpp"

namespace ovws::design {
namespace {

// Odd numbers only: with an even one, half a subaperture is left free at the pupil's edge.
constexpr int kLeastAcross = 3, kMostAcross = limits::kSubaperturesAcross.max;
constexpr int kMoreTries = 2;  ///< larger numbers that are tried, too

int least_across(const Bench& bench) {
  int across = bench.modes ? kLeastAcross : kUsualAcross;
  while (bench.modes && optimal_mode_count(across) < *bench.modes) across += 2;
  return across;
}

std::vector<Candidate> make_candidates(const Bench& bench, const Config& base, Shapes shapes) {
  std::vector<Candidate> all;
  const auto add = [&](int across, bool by_shapes) {
    all.push_back(make_candidate(bench, base, across, by_shapes));
  };
  const int first = least_across(bench);
  for (int across = first; across <= std::min(first + 2 * kMoreTries, kMostAcross); across += 2) {
    add(across, false);
  }
  if (!bench.modes) add(kLeastAcross, false);
  if (shapes == Shapes::unused || !bench.modes || bench.charge == 0) return all;
  // A vortex determines about 2.5 modes; a lattice has about 3/4 of the square of its number
  // across.
  for (int across = first - 2; across >= kLeastAcross; across -= 2) {
    if (2.5 * 0.75 * across * across < *bench.modes) break;
    add(across, true);
  }
  return all;
}

}  // namespace

tl::expected<Config, Finding> find_config(const Bench& bench, const Config& base, Shapes shapes) {
  const int most = optimal_mode_count(kMostAcross);
  if (bench.modes.value_or(0) > most) {
    return tl::make_unexpected(
        Finding{Limit::modes,
                fmt::format("{} modes need more than {} subapertures across, the program's limit",
                            *bench.modes, kMostAcross),
                ""});
  }
  const auto candidates = make_candidates(bench, base, shapes);
  std::optional<Finding> first;
  for (const double finest_cpp : {kComfortableCpp, kNyquistCpp}) {
    first.reset();
    for (const Candidate& candidate : candidates) {
      auto config = attempt(candidate, finest_cpp);
      if (config) return config;
      if (!first) first = config.error();
    }
  }
  return tl::make_unexpected(*first);
}

}  // namespace ovws::design
