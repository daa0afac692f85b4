/// Study `acquisition`: fractions of refused and wrong spots when one image is searched without
/// history.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>
#include <random>

#include "core/optics/random_modes.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/searcher.hpp"
#include "daemon/ovws/study/sensor.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kRandomRmsWaves = 0.5;
constexpr int kLastRandom = 18;  // OSA index: random wavefronts have the modes j = 3 to 18

struct Scene {
  std::string name;
  int images = 0;  ///< exposures at each level
  Image<float> light_e;
  std::vector<Vec2> at_px;  ///< positions predicted by the slope matrix
};

struct Counts {
  int spots = 0, refused = 0, gross = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Counts, spots, refused, gross)

std::vector<Scene> scenes(const Settings& settings, SensorModel& model, const Measurer& measurer) {
  std::vector<std::pair<std::string, std::vector<Mode>>> all;
  for (const double unit_waves : {2.0, -2.0}) {
    for (const int j : {3, 4}) {
      const double waves = unit_waves / zernike_rms_factor(j);
      all.push_back({fmt::format("{} {:+} waves", zernike_name(j), unit_waves), {{j, waves}}});
    }
  }
  const std::size_t single = all.size();
  std::mt19937_64 random(settings.seed);
  for (int k = 0; k < (settings.quick ? 6 : 60); ++k) {
    all.push_back(
        {fmt::format("random {}", k), random_modes(random, kLastRandom, kRandomRmsWaves)});
  }
  const int images_of_one = settings.quick ? 5 : 50, images_of_random = settings.quick ? 2 : 10;
  std::vector<Scene> out;
  for (const auto& [name, modes] : all) {
    out.push_back({name, out.size() < single ? images_of_one : images_of_random,
                   electrons(model, model, modes, Light::equal_peak),
                   measurer.predicted_px(modes)});
  }
  return out;
}

Counts acquire(const Measurer& measurer, const Scene& scene, double snr, std::uint64_t seed) {
  Counts counts;
  Searcher searcher(default_bench(), measurer);
  for (int k = 0; k < scene.images; ++k) {
    const Exposure exposure = expose(scene.light_e, read_noise_of_snr(snr), seed + unsigned(k));
    const std::vector<SpotFix> fixes = searcher.find(exposure, read_noise_of_snr(snr));
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      ++counts.spots;
      const Vec2 at{fixes[i].x, fixes[i].y};
      if (!fixes[i].found()) {
        ++counts.refused;
      } else if (norm(at - scene.at_px[i]) > kGross * measurer.lambda_d_px()) {
        ++counts.gross;
      }
    }
  }
  return counts;
}

/// Every scene for one tracker.
struct Search {
  TrackerKind kind;
  std::unique_ptr<const Measurer> measurer;
  std::vector<Scene> scenes;
};

std::vector<Search> searches_of(const Settings& settings) {
  const auto model = model_of(default_bench(), 1);
  std::vector<Search> all;
  for (const TrackerKind kind : {TrackerKind::lg, TrackerKind::fit}) {
    auto measurer = std::make_unique<const Measurer>(default_bench(), Method{"", 1, {kind}}, model);
    std::vector<Scene> seen = scenes(settings, *model, *measurer);
    all.push_back({kind, std::move(measurer), std::move(seen)});
  }
  return all;
}

/// `counts`: of each search, its scenes by SNR.
Findings acquisition_findings(const std::vector<Search>& searches, const std::vector<double>& snrs,
                              const std::vector<Counts>& counts) {
  nlohmann::json summary{
      {"study", "acquisition"}, {"peak_e", kPeakE}, {"rows", nlohmann::json::array()}};
  Figure figure{"acquisition",
                "Spots refused or wrong in a search of one image: 2 waves of one mode, 0.5 wave "
                "RMS of random "
                "modes",
                "peak SNR", "fraction of spots"};
  std::size_t before = 0;  // counts of the searches before
  for (const auto& [kind, measurer, all] : searches) {
    Series refused{.name = fmt::format("{}, refused", tracker_name(kind))};
    Series gross{.name = fmt::format("{}, wrong", tracker_name(kind))};
    for (std::size_t s = 0; s < snrs.size(); ++s) {
      Counts sum;
      for (std::size_t c = 0; c < all.size(); ++c) {
        const Counts& one = counts[before + c * snrs.size() + s];
        sum.spots += one.spots;
        sum.refused += one.refused;
        sum.gross += one.gross;
        summary["rows"].push_back({{"tracker", tracker_name(kind)},
                                   {"scene", all[c].name},
                                   {"snr", snrs[s]},
                                   {"spots", one.spots},
                                   {"refused", one.refused},
                                   {"gross", one.gross}});
      }
      refused.add(snrs[s], double(sum.refused) / sum.spots);
      gross.add(snrs[s], double(sum.gross) / sum.spots);
    }
    figure.series.push_back(std::move(refused));
    figure.series.push_back(std::move(gross));
    before += all.size() * snrs.size();
  }
  figure.y_from = 0.0;
  figure.y_to = 0.01;  // minimum of the range: all values may be zero
  for (const Series& series : figure.series) {
    figure.y_to = std::max(figure.y_to, 1.1 * *std::max_element(series.y.begin(), series.y.end()));
  }
  return {std::move(summary), {std::move(figure)}};
}

}  // namespace

Work acquisition(const Settings& settings) {
  const std::vector<double> snrs = settings.quick
                                       ? std::vector<double>{2.0, 5.0, 22.0}
                                       : std::vector<double>{2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 22.0};
  const auto searches = std::make_shared<const std::vector<Search>>(searches_of(settings));
  const std::size_t each = searches->front().scenes.size() * snrs.size();
  return work_of(
      searches->size() * each,
      [=, seed = settings.seed](std::size_t item) {
        const Search& search = (*searches)[item / each];
        const std::size_t k = item % each;  // both trackers see the same noise
        return acquire(*search.measurer, search.scenes[k / snrs.size()], snrs[k % snrs.size()],
                       seed + 1000 * k);
      },
      [=](const std::vector<Counts>& counts) {
        return acquisition_findings(*searches, snrs, counts);
      });
}

}  // namespace ovws::study
