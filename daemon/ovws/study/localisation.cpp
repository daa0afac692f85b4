/// Study of the position errors of one spot against read noise, as in the paper's figure
/// "Localization precision".
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>
#include <span>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kCloudNoiseE = 55.0;  ///< read noise of the point clouds

/// The errors of one method at one read noise.
struct CloudPoint {
  Mean rms_px;
  double bound_px = kUnknown;
  int lost = 0;
  std::vector<double> x_px{}, y_px{};  ///< errors of each realisation, for the figure of clouds
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CloudPoint, rms_px, bound_px, lost, x_px, y_px)

/// Errors of every method at every read noise.
struct NoiseSweep {
  std::vector<SpotBench> benches = all_spot_benches();
  std::vector<double> noises_e;
  int realisations;
  std::uint64_t seed;

  std::size_t size() const { return benches.size() * noises_e.size(); }
  const SpotBench& bench_of(std::size_t k) const { return benches[k / noises_e.size()]; }
  double read_noise_e(std::size_t k) const { return noises_e[k % noises_e.size()]; }
  CloudPoint measure(std::size_t k) const {
    const Cloud cloud = cloud_of(bench_of(k), read_noise_e(k), realisations, seed + 1000 * k);
    return {root_of(cloud.squares_px2), bound_px(bench_of(k), read_noise_e(k)), cloud.lost};
  }
};

/// Adds one series per method at this light level. After the last method of each charge, adds the
/// charge's Cramer-Rao bound.
Figure sweep_figure(Figure figure, Light light, const NoiseSweep& sweep,
                    const std::vector<CloudPoint>& points) {
  const std::vector<SpotBench>& benches = sweep.benches;
  for (std::size_t b = 0; b < benches.size(); ++b) {
    if (benches[b].light != light) continue;
    const int charge = benches[b].method.charge;
    Series series{.name = benches[b].method.name};
    Series bound{.name = fmt::format("bound, charge {}", charge), .style = Series::Style::line};
    for (std::size_t k = 0; k < sweep.size(); ++k) {
      if (&sweep.bench_of(k) != &benches[b]) continue;
      series.add(sweep.read_noise_e(k), points[k].rms_px);
      bound.add(sweep.read_noise_e(k), points[k].bound_px);
    }
    figure.series.push_back(std::move(series));
    const bool more = b + 1 < benches.size() && benches[b + 1].light == light &&
                      benches[b + 1].method.charge == charge;
    if (!more) figure.series.push_back(std::move(bound));
  }
  return figure;
}

/// `clouds`: one for each bench at equal peak.
Figure cloud_figure(const std::vector<SpotBench>& all, std::span<const CloudPoint> clouds) {
  Figure figure{
      "localisation-clouds",
      fmt::format("Position errors of one spot, read noise {} e, peak {} e", kCloudNoiseE, kPeakE),
      "x error (px)", "y error (px)"};
  figure.same_scale = true;
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    const std::string& name = all[c].method.name;
    figure.series.push_back({name, clouds[c].x_px, clouds[c].y_px, {}, Series::Style::points});
  }
  return figure;
}

/// `points`: those of the sweep, then the clouds.
Findings localised(const NoiseSweep& sweep, const std::vector<CloudPoint>& points) {
  Findings found{{{"study", "localisation"},
                  {"unit", "px RMS per axis"},
                  {"peak_e", kPeakE},
                  {"realisations", sweep.realisations},
                  {"rows", nlohmann::json::array()}},
                 {}};
  for (std::size_t k = 0; k < sweep.size(); ++k) {
    const CloudPoint& point = points[k];
    found.summary["rows"].push_back({{"light", name_of(sweep.bench_of(k).light)},
                                     {"method", sweep.bench_of(k).method.name},
                                     {"read_noise_e", sweep.read_noise_e(k)},
                                     {"snr", snr_of_read_noise(sweep.read_noise_e(k))},
                                     {"rms_px", point.rms_px.value},
                                     {"standard_error_px", point.rms_px.standard_error},
                                     {"lost", point.lost}});
  }
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    Figure figure{light == Light::equal_peak ? "localisation" : "localisation-photons",
                  fmt::format("Localisation of one spot at {}", name_of(light)),
                  "read noise (electrons RMS)", "position error (px RMS per axis)"};
    figure.log_y = true;
    found.figures.push_back(sweep_figure(std::move(figure), light, sweep, points));
  }
  found.figures.push_back(cloud_figure(sweep.benches, std::span(points).subspan(sweep.size())));
  return found;
}

}  // namespace

/// Its items: the points of the sweep, then a cloud for each bench at equal peak, which are the
/// first benches.
Work localisation(const Settings& settings) {
  const int realisations = settings.quick ? 30 : 100;
  const double step_e = settings.quick ? 40.0 : 10.0;
  std::vector<double> noises_e;
  for (double noise_e = 5.0; noise_e <= 85.0; noise_e += step_e) noises_e.push_back(noise_e);
  const auto sweep = std::make_shared<const NoiseSweep>(
      NoiseSweep{.noises_e = noises_e, .realisations = realisations, .seed = settings.seed});
  const auto clouds =
      std::count_if(sweep->benches.begin(), sweep->benches.end(),
                    [](const SpotBench& bench) { return bench.light == Light::equal_peak; });
  const auto measure = [sweep](std::size_t k) {
    if (k < sweep->size()) return sweep->measure(k);
    const SpotBench& bench = sweep->benches[k - sweep->size()];
    Cloud cloud = cloud_of(bench, kCloudNoiseE, sweep->realisations, sweep->seed);
    return CloudPoint{{}, kUnknown, cloud.lost, std::move(cloud.x_px), std::move(cloud.y_px)};
  };
  return work_of(
      sweep->size() + std::size_t(clouds), measure,
      [sweep](const std::vector<CloudPoint>& points) { return localised(*sweep, points); });
}

}  // namespace ovws::study
