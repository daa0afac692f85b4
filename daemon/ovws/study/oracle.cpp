/// Study `oracle`: compares the fast `lg` tracker with the paper's contour method, spot by spot.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kLowestSnr = 5.0, kHighestSnr = 22.0;
constexpr double kAgreePx = 0.01;

/// Positions of one spot by both methods, px; NaN: not found.
struct Pair {
  double snr = 0.0;
  float x = 0.0F, y = 0.0F;                  ///< by lg
  float contour_x = 0.0F, contour_y = 0.0F;  ///< by the contour method
  bool fast_found() const { return !std::isnan(x); }
  bool contour_found() const { return !std::isnan(contour_x); }
  bool both() const { return fast_found() && contour_found(); }
  double apart_px() const { return std::hypot(double(x - contour_x), double(y - contour_y)); }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Pair, snr, x, y, contour_x, contour_y)

Pair compare(const SpotBench& fast, const SpotBench& contour, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const double reach_px = kStartWithin * fast.measurer->lambda_d_px();
  std::uniform_real_distribution<double> within(-reach_px, reach_px);
  Pair pair;
  pair.snr = std::uniform_real_distribution<double>(kLowestSnr, kHighestSnr)(random);
  const std::vector<Vec2> start{fast.at_px + Vec2{within(random), within(random)}};
  const Exposure exposure = expose(fast.light_e, read_noise_of_snr(pair.snr), random());
  const SpotFix by_lg = fast.measurer->track(exposure, start).front();
  const SpotFix by_contour = contour.measurer->track(exposure, start).front();
  return {pair.snr, by_lg.x, by_lg.y, by_contour.x, by_contour.y};
}

nlohmann::json pair_json(const Pair& pair) {
  return {{"snr", pair.snr},
          {"lg", {pair.x, pair.y}},
          {"lg_contour", {pair.contour_x, pair.contour_y}},
          {"apart_px", pair.apart_px()}};
}

Findings oracle_findings(const std::vector<Pair>& pairs) {
  nlohmann::json summary{{"study", "oracle"},
                         {"spots", pairs.size()},
                         {"agree_px", kAgreePx},
                         {"rows", nlohmann::json::array()}};
  Series apart{"both found", {}, {}, {}, Series::Style::points};
  std::size_t both = 0, agree = 0;
  for (const Pair& pair : pairs) {
    if (!pair.both()) continue;
    ++both;
    apart.add(pair.snr, std::max(pair.apart_px(), 1e-7));
    pair.apart_px() <= kAgreePx ? void(++agree) : summary["rows"].push_back(pair_json(pair));
  }
  summary["both_found"] = both;
  summary["agree"] = agree;
  summary["only_lg"] = std::count_if(pairs.begin(), pairs.end(), [](const Pair& p) {
    return p.fast_found() && !p.contour_found();
  });
  summary["only_lg_contour"] = std::count_if(pairs.begin(), pairs.end(), [](const Pair& p) {
    return !p.fast_found() && p.contour_found();
  });
  Figure figure{"oracle",   "lg and the paper's contour method on the same noisy vortex",
                "peak SNR", "distance between the two (px)",
                false,      true,
                false,      {apart}};
  return {std::move(summary), {std::move(figure)}};
}

}  // namespace

Work oracle(const Settings& settings) {
  const auto vortex = model_of(default_bench(), 1);
  const SpotBench fast =
      spot_bench({"lg", 1, {TrackerKind::lg}}, Light::equal_peak, vortex, vortex);
  const SpotBench contour =
      spot_bench({"lg_contour", 1, {TrackerKind::lg_contour}}, Light::equal_peak, vortex, vortex);
  return work_of(
      settings.quick ? 200 : 10'000,
      [fast, contour, seed = settings.seed](std::size_t k) {
        return compare(fast, contour, seed + 1000 * k);
      },
      oracle_findings);
}

}  // namespace ovws::study
