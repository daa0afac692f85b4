/// Study `oracle`: compares the fast `lg` tracker with the paper's contour method, spot by spot.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kLowestSnr = 5.0, kHighestSnr = 22.0;
constexpr double kStartWithin = 0.3;  ///< lambda/d
constexpr double kAgreePx = 0.01;

struct Pair {
  double snr = 0.0;
  SpotFix fast, contour;
  bool both() const { return fast.found() && contour.found(); }
  double apart_px() const {
    return std::hypot(double(fast.x - contour.x), double(fast.y - contour.y));
  }
};

Pair compare(const SpotBench& fast, const SpotBench& contour, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const double reach_px = kStartWithin * fast.measurer->lambda_d_px();
  std::uniform_real_distribution<double> within(-reach_px, reach_px);
  Pair pair;
  pair.snr = std::uniform_real_distribution<double>(kLowestSnr, kHighestSnr)(random);
  const std::vector<Vec2> start{fast.at_px + Vec2{within(random), within(random)}};
  const Exposure exposure = expose(fast.light_e, read_noise_of_snr(pair.snr), random());
  pair.fast = fast.measurer->track(exposure, start).front();
  pair.contour = contour.measurer->track(exposure, start).front();
  return pair;
}

nlohmann::json json_of(const Pair& pair) {
  return {{"snr", pair.snr},
          {"lg", {pair.fast.x, pair.fast.y}},
          {"lg_contour", {pair.contour.x, pair.contour.y}},
          {"apart_px", pair.apart_px()}};
}

}  // namespace

Findings oracle(const Settings& settings) {
  const std::size_t spots = settings.quick ? 200 : 10'000;
  const auto vortex = model_of(default_bench(), 1);
  const SpotBench fast =
      spot_bench({"lg", 1, {TrackerKind::lg}}, Light::equal_peak, vortex, vortex);
  const SpotBench contour =
      spot_bench({"lg_contour", 1, {TrackerKind::lg_contour}}, Light::equal_peak, vortex, vortex);
  std::vector<Pair> pairs(spots);
  parallel_for("oracle", spots, settings.threads,
               [&](std::size_t k) { pairs[k] = compare(fast, contour, settings.seed + 1000 * k); });
  nlohmann::json summary{{"study", "oracle"},
                         {"spots", spots},
                         {"agree_px", kAgreePx},
                         {"rows", nlohmann::json::array()}};
  Series apart{"both found", {}, {}, {}, Series::Style::points};
  std::size_t both = 0, agree = 0;
  for (const Pair& pair : pairs) {
    if (!pair.both()) continue;
    ++both;
    apart.add(pair.snr, std::max(pair.apart_px(), 1e-7));
    pair.apart_px() <= kAgreePx ? void(++agree) : summary["rows"].push_back(json_of(pair));
  }
  summary["both_found"] = both;
  summary["agree"] = agree;
  summary["only_lg"] = std::count_if(pairs.begin(), pairs.end(), [](const Pair& p) {
    return p.fast.found() && !p.contour.found();
  });
  summary["only_lg_contour"] = std::count_if(pairs.begin(), pairs.end(), [](const Pair& p) {
    return !p.fast.found() && p.contour.found();
  });
  Figure figure{"oracle",   "lg and the paper's contour method on the same noisy vortex",
                "peak SNR", "distance between the two (px)",
                false,      true,
                false,      {apart}};
  return {std::move(summary), {std::move(figure)}};
}

}  // namespace ovws::study
