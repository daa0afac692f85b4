/// Studies of the position errors of one spot: `localisation` against read noise, as in the paper's
/// figure "Localization precision", and `trackers` against SNR and the Cramer-Rao bound.
#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kCloudNoiseE = 55.0;  ///< read noise of the point clouds

/// The errors of one method at one read noise.
struct Point {
  const SpotBench* bench;
  double x;  ///< x value in the figure: read noise or SNR
  double read_noise_e;
  Mean rms_px;
  double bound_px;
  int lost;
};

/// Errors of every method at every x, which is a read noise or an SNR.
std::vector<Point> sweep(const char* study, const std::vector<SpotBench>& benches,
                         const std::vector<double>& all_x, double (*read_noise_e_of)(double x),
                         int realisations, const Settings& settings) {
  std::vector<Point> points(benches.size() * all_x.size());
  parallel_for(study, points.size(), settings.threads, [&](std::size_t k) {
    const SpotBench& bench = benches[k / all_x.size()];
    const double x = all_x[k % all_x.size()], read_noise_e = read_noise_e_of(x);
    const Cloud cloud = cloud_of(bench, read_noise_e, realisations, settings.seed + 1000 * k);
    points[k] = {
        &bench,    x, read_noise_e, root_of(cloud.squares_px2), bound_px(bench, read_noise_e),
        cloud.lost};
  });
  return points;
}

/// Adds one series per method at this light level. After the last method of each charge, adds the
/// charge's Cramer-Rao bound.
Figure figure_of(Figure figure, Light light, const std::vector<SpotBench>& benches,
                 const std::vector<Point>& points) {
  for (std::size_t b = 0; b < benches.size(); ++b) {
    if (benches[b].light != light) continue;
    const int charge = benches[b].method.charge;
    Series series{.name = benches[b].method.name};
    Series bound{.name = fmt::format("bound, charge {}", charge), .style = Series::Style::line};
    for (const Point& point : points) {
      if (point.bench != &benches[b]) continue;
      series.add(point.x, point.rms_px);
      bound.add(point.x, point.bound_px);
    }
    figure.series.push_back(std::move(series));
    const bool more = b + 1 < benches.size() && benches[b + 1].light == light &&
                      benches[b + 1].method.charge == charge;
    if (!more) figure.series.push_back(std::move(bound));
  }
  return figure;
}

nlohmann::json summary_of(const char* study, int realisations) {
  return {{"study", study},
          {"unit", "px RMS per axis"},
          {"peak_e", kPeakE},
          {"realisations", realisations},
          {"rows", nlohmann::json::array()}};
}

Figure cloud_figure(const std::vector<SpotBench>& all, const Settings& settings) {
  Figure figure{
      "localisation-clouds",
      fmt::format("Position errors of one spot, read noise {} e, peak {} e", kCloudNoiseE, kPeakE),
      "x error (px)", "y error (px)"};
  figure.same_scale = true;
  for (const SpotBench& bench : all) {
    if (bench.light != Light::equal_peak) continue;
    const Cloud cloud = cloud_of(bench, kCloudNoiseE, settings.quick ? 30 : 100, settings.seed);
    figure.series.push_back({bench.method.name, cloud.x_px, cloud.y_px, {}, Series::Style::points});
  }
  return figure;
}

}  // namespace

Findings localisation(const Settings& settings) {
  const int realisations = settings.quick ? 30 : 100;
  const double step_e = settings.quick ? 40.0 : 10.0;
  std::vector<double> noises_e;
  for (double noise_e = 5.0; noise_e <= 85.0; noise_e += step_e) noises_e.push_back(noise_e);
  const std::vector<SpotBench> benches = all_spot_benches();
  const std::vector<Point> points = sweep(
      "localisation", benches, noises_e, [](double noise_e) { return noise_e; }, realisations,
      settings);
  Findings found{summary_of("localisation", realisations), {}};
  for (const Point& point : points) {
    found.summary["rows"].push_back({{"light", name_of(point.bench->light)},
                                     {"method", point.bench->method.name},
                                     {"read_noise_e", point.read_noise_e},
                                     {"snr", snr_of_read_noise(point.read_noise_e)},
                                     {"rms_px", point.rms_px.value},
                                     {"standard_error_px", point.rms_px.standard_error},
                                     {"lost", point.lost}});
  }
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    Figure figure{light == Light::equal_peak ? "localisation" : "localisation-photons",
                  fmt::format("Localisation of one spot at {}", name_of(light)),
                  "read noise (electrons RMS)", "position error (px RMS per axis)"};
    figure.log_y = true;
    found.figures.push_back(figure_of(std::move(figure), light, benches, points));
  }
  found.figures.push_back(cloud_figure(benches, settings));
  return found;
}

Findings trackers(const Settings& settings) {
  const std::vector<double> snrs = settings.quick
                                       ? std::vector<double>{3.0, 8.0, 22.0}
                                       : std::vector<double>{2.0, 3.0, 4.0, 5.0, 8.0, 12.0, 22.0};
  const int realisations = settings.quick ? 100 : 1000;
  const std::vector<SpotBench> benches = all_spot_benches();
  const std::vector<Point> points =
      sweep("trackers", benches, snrs, read_noise_of_snr, realisations, settings);
  Findings found{summary_of("trackers", realisations), {}};
  for (const Point& point : points) {
    found.summary["rows"].push_back({{"light", name_of(point.bench->light)},
                                     {"method", point.bench->method.name},
                                     {"snr", point.x},
                                     {"rms_px", point.rms_px.value},
                                     {"standard_error_px", point.rms_px.standard_error},
                                     {"bound_px", point.bound_px},
                                     {"factor", point.rms_px.value / point.bound_px},
                                     {"lost", point.lost}});
  }
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    const bool peak = light == Light::equal_peak;
    Figure figure{peak ? "trackers" : "trackers-photons",
                  fmt::format("Every tracker and its bound at {}", name_of(light)),
                  peak ? "peak SNR" : "peak SNR of the vortex", "position error (px RMS per axis)"};
    figure.log_x = figure.log_y = true;
    found.figures.push_back(figure_of(std::move(figure), light, benches, points));
  }
  return found;
}

}  // namespace ovws::study
