/// Study `localisation`: position errors of one spot against read noise, as in the paper's figure
/// "Localization precision".
#include <spdlog/fmt/fmt.h>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kCloudNoiseE = 55.0;  ///< read noise of the point clouds

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
  const std::vector<SpotBench> all = all_spot_benches();
  std::vector<Cloud> clouds(all.size() * noises_e.size());
  parallel_for("localisation", clouds.size(), settings.threads, [&](std::size_t k) {
    clouds[k] = cloud_of(all[k / noises_e.size()], noises_e[k % noises_e.size()], realisations,
                         settings.seed + 1000 * k);
  });
  Findings found;
  found.summary = {{"study", "localisation"},
                   {"unit", "px RMS per axis"},
                   {"peak_e", kPeakE},
                   {"realisations", realisations},
                   {"rows", nlohmann::json::array()}};
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    Figure figure{light == Light::equal_peak ? "localisation" : "localisation-photons",
                  fmt::format("Localisation of one spot at {}", name_of(light)),
                  "read noise (electrons RMS)", "position error (px RMS per axis)"};
    figure.log_y = true;
    for (std::size_t b = 0; b < all.size(); ++b) {
      if (all[b].light != light) continue;
      Series series{all[b].method.name, noises_e, {}, {}};
      for (std::size_t n = 0; n < noises_e.size(); ++n) {
        const Cloud& cloud = clouds[b * noises_e.size() + n];
        const Mean rms = root_of(cloud.squares_px2);
        series.y.push_back(rms.value);
        series.error.push_back(rms.standard_error);
        found.summary["rows"].push_back({{"light", name_of(light)},
                                         {"method", all[b].method.name},
                                         {"read_noise_e", noises_e[n]},
                                         {"snr", snr_of_read_noise(noises_e[n])},
                                         {"rms_px", rms.value},
                                         {"standard_error_px", rms.standard_error},
                                         {"lost", cloud.lost}});
      }
      figure.series.push_back(std::move(series));
      if (all[b].method.tracking.tracker != TrackerKind::fit) continue;
      Series bound{fmt::format("bound, charge {}", all[b].method.charge),
                   noises_e,
                   {},
                   {},
                   Series::Style::line};
      for (const double noise_e : noises_e) bound.y.push_back(bound_px(all[b], noise_e));
      figure.series.push_back(std::move(bound));
    }
    found.figures.push_back(std::move(figure));
  }
  found.figures.push_back(cloud_figure(all, settings));
  return found;
}

}  // namespace ovws::study
