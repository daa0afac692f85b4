/// The LG kernel's radius: the best one against SNR.
#include <spdlog/fmt/fmt.h>

#include "daemon/study/cloud.hpp"
#include "daemon/study/figure.hpp"
#include "daemon/study/parallel.hpp"
#include "daemon/study/statistics.hpp"
#include "daemon/study/studies.hpp"

namespace ovws::study {

Findings kernel(const Settings& settings) {
  const std::vector<double> snrs{2.0, 5.0, 10.0, 22.0};
  const std::vector<double> radii =
      settings.quick ? std::vector<double>{0.2, 0.3, 0.45}
                     : std::vector<double>{0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6};
  const int realisations = settings.quick ? 30 : 400;
  const auto vortex = model_of(default_bench(), 1);
  std::vector<SpotBench> benches;
  for (const double radius : radii) {
    const Method method{fmt::format("radius {}", radius), 1, {TrackerKind::lg, radius}};
    benches.push_back(spot_bench(method, Light::equal_peak, vortex, vortex));
  }
  std::vector<Cloud> clouds(radii.size() * snrs.size());
  parallel_for("kernel", clouds.size(), settings.threads, [&](std::size_t k) {
    clouds[k] = cloud_of(benches[k / snrs.size()], read_noise_of_snr(snrs[k % snrs.size()]),
                         realisations, settings.seed + 1000 * k);
  });
  nlohmann::json summary{{"study", "kernel"},
                         {"unit", "px RMS per axis"},
                         {"peak_e", kPeakE},
                         {"realisations", realisations},
                         {"rows", nlohmann::json::array()}};
  Figure figure{"kernel", "LG on a vortex at equal peak: error against the kernel's radius",
                "kernel 1/e radius (lambda/d)", "position error (px RMS per axis)"};
  figure.log_y = true;
  for (std::size_t s = 0; s < snrs.size(); ++s) {
    Series series{fmt::format("peak SNR {}", snrs[s]), radii, {}, {}};
    for (std::size_t r = 0; r < radii.size(); ++r) {
      const Cloud& cloud = clouds[r * snrs.size() + s];
      const Mean rms = root_of(cloud.squares_px2);
      series.y.push_back(rms.value);
      series.error.push_back(rms.standard_error);
      summary["rows"].push_back({{"radius", radii[r]},
                                 {"snr", snrs[s]},
                                 {"rms_px", rms.value},
                                 {"standard_error_px", rms.standard_error},
                                 {"lost", cloud.lost}});
    }
    figure.series.push_back(std::move(series));
  }
  return {std::move(summary), {std::move(figure)}};
}

}  // namespace ovws::study
