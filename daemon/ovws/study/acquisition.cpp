/// Study `acquisition`: fractions of refused and wrong spots when one image is searched without
/// history.
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>
#include <random>

#include "core/optics/random_modes.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/fitting.hpp"
#include "daemon/ovws/study/sensor.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

using nlohmann::json;

constexpr double kRandomRmsWaves = 0.5;
constexpr int kLastRandom = 18;  // OSA index: random wavefronts have the modes j = 3 to 18
constexpr std::array kSearchTrackers{TrackerKind::lg, TrackerKind::fit};

struct Scene {
  std::string name;
  int images = 0;  ///< exposures at each level
  Image<float> light_e;
  std::vector<Vec2> at_px;  ///< positions predicted by the slope matrix
};

std::vector<Scene> scenes(const Settings& settings, const SensorPair& sensors,
                          const Measurer& measurer) {
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
                   sensors.electrons(1, modes, Light::equal_peak), measurer.predicted_px(modes)});
  }
  return out;
}

json acquire(const Measurer& measurer, const Scene& scene, double snr, std::uint64_t seed) {
  int spots = 0, refused = 0, gross = 0;
  Searcher searcher(default_bench(), measurer);
  for (int k = 0; k < scene.images; ++k) {
    const Exposure exposure = expose(scene.light_e, read_noise_of_snr(snr), seed + unsigned(k));
    const std::vector<SpotFix> fixes = searcher.find(exposure, read_noise_of_snr(snr));
    for (std::size_t i = 0; i < fixes.size(); ++i) {
      ++spots;
      const Vec2 at{fixes[i].x, fixes[i].y};
      if (!fixes[i].found()) {
        ++refused;
      } else if (norm(at - scene.at_px[i]) > kGross * measurer.lambda_d_px()) {
        ++gross;
      }
    }
  }
  return {{"spots", spots}, {"refused", refused}, {"gross", gross}};
}

/// Every scene for one tracker.
struct Search {
  std::unique_ptr<const Measurer> measurer;
  std::vector<Scene> scenes;
};

std::vector<Search> searches_of(const Settings& settings) {
  const SensorPair sensors(default_bench());
  std::vector<Search> all;
  for (const TrackerKind kind : kSearchTrackers) {
    auto measurer =
        std::make_unique<const Measurer>(default_bench(), Method{"", 1, {kind}}, sensors.of(1));
    std::vector<Scene> seen = scenes(settings, sensors, *measurer);
    all.push_back({std::move(measurer), std::move(seen)});
  }
  return all;
}

double sum_of(const Rows& rows, const char* key) {
  double sum = 0.0;
  for (const json& row : rows) sum += row.at(key).get<double>();
  return sum;
}

Figure acquisition_figure(const std::vector<double>& snrs, const Rows& rows) {
  Figure figure{"acquisition",
                "Spots refused or wrong in a search of one image: 2 waves of one mode, 0.5 wave "
                "RMS of random "
                "modes",
                "peak SNR", "fraction of spots"};
  figure.y_from = 0.0;
  figure.y_to = 0.01;  // minimum of the range: all values may be zero
  for (const TrackerKind kind : kSearchTrackers) {
    for (const auto& [key, what] : {std::pair{"refused", "refused"}, {"gross", "wrong"}}) {
      Series series{.name = fmt::format("{}, {}", tracker_name(kind), what)};
      for (const double snr : snrs) {
        const Rows of = rows_with(rows, {{"tracker", tracker_name(kind)}, {"snr", snr}});
        series.add(snr, sum_of(of, key) / sum_of(of, "spots"));
      }
      figure.y_to = std::max(figure.y_to, 1.1 * std::ranges::max(series.y));
      figure.add(std::move(series));
    }
  }
  return figure;
}

}  // namespace

Work acquisition(const Settings& settings) {
  const std::vector<double> snrs = settings.quick
                                       ? std::vector<double>{2.0, 5.0, 22.0}
                                       : std::vector<double>{2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 22.0};
  const auto searches = std::make_shared<const std::vector<Search>>(searches_of(settings));
  const std::size_t count = searches->front().scenes.size();
  Rows conditions;
  for (const TrackerKind kind : kSearchTrackers) {
    for (const double snr : snrs) {
      for (const Scene& scene : searches->front().scenes) {
        conditions.push_back(
            {{"tracker", tracker_name(kind)}, {"scene", scene.name}, {"snr", snr}});
      }
    }
  }
  const auto measure = [=, seed = settings.seed](std::size_t item) {
    const Search& search = (*searches)[item / (count * snrs.size())];
    const std::size_t level = item / count % snrs.size(), scene = item % count;
    // Both trackers see the same noise.
    return acquire(*search.measurer, search.scenes[scene], snrs[level],
                   seed + 1000 * (scene * snrs.size() + level));
  };
  return work_of({{{"study", "acquisition"}, {"peak_e", kPeakE}},
                  std::move(conditions),
                  measure,
                  [snrs](const Rows& rows, Findings& found) {
                    found.figures.push_back(acquisition_figure(snrs, rows));
                  }});
}

}  // namespace ovws::study
