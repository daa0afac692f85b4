#include "daemon/ovws/design/search.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <vector>

#include "core/optics/zernike.hpp"

namespace ovws::design {
namespace {

constexpr int kMoreTries = 2;  ///< larger numbers that are tried, too

/// The smallest number whose spots' positions determine the modes.
int least_across(const Bench& bench) {
  int across = bench.modes ? kLeastAcross : kUsualAcross;
  while (bench.modes && optimal_mode_count(across) < *bench.modes) across += 2;
  return across;
}

bool shapes_may_do(const Bench& bench, int across) {
  return bench.charge != 0 && most_modes_by_shapes(across) >= *bench.modes;
}

std::vector<Candidate> make_candidates(const Bench& bench, const Config& base, Shapes shapes) {
  std::vector<Candidate> all;
  const auto add = [&](int across, bool by_shapes) {
    all.push_back(make_candidate(bench, base, across, by_shapes));
  };
  const int first = least_across(bench);
  const bool uses_shapes = shapes == Shapes::used && bench.modes;
  for (int across = kUsualAcross; uses_shapes && across < first; across += 2) {
    if (shapes_may_do(bench, across)) add(across, true);
  }
  for (int across = first; across <= std::min(first + 2 * kMoreTries, kMostAcross); across += 2) {
    add(across, false);
  }
  if (!bench.modes) add(kLeastAcross, false);
  if (uses_shapes && kLeastAcross < first && shapes_may_do(bench, kLeastAcross)) {
    add(kLeastAcross, true);
  }
  return all;
}

}  // namespace

tl::expected<Config, Finding> find_config(const Bench& bench, const Config& base, Shapes shapes) {
  const int most = optimal_mode_count(kMostAcross);
  if (bench.modes.value_or(0) > most) {
    return tl::make_unexpected(Finding{
        Limit::modes,
        fmt::format("{} modes need more than {} subapertures across, the largest number designed",
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
      if (!first && !candidate.config.tracking.mode_count) first = config.error();
    }
  }
  // A number up to kMostAcross determines the modes by positions: `first` is of its candidate.
  return tl::make_unexpected(*first);
}

}  // namespace ovws::design
