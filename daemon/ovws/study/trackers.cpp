/// Study `trackers`: position errors of every tracker against the Cramer-Rao bound.
#include <spdlog/fmt/fmt.h>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

struct Row {
  Mean rms_px;
  double bound_px = 0.0;
  int lost = 0;
};

nlohmann::json json_of(const SpotBench& bench, double snr, const Row& row) {
  return {{"light", name_of(bench.light)},
          {"method", bench.method.name},
          {"snr", snr},
          {"rms_px", row.rms_px.value},
          {"standard_error_px", row.rms_px.standard_error},
          {"bound_px", row.bound_px},
          {"factor", row.rms_px.value / row.bound_px},
          {"lost", row.lost}};
}

Figure figure_of(Light light, const std::vector<SpotBench>& benches,
                 const std::vector<double>& snrs, const std::vector<Row>& rows) {
  Figure figure;
  figure.name = light == Light::equal_peak ? "trackers" : "trackers-photons";
  figure.title = fmt::format("Every tracker and its bound at {}", name_of(light));
  figure.x_label = light == Light::equal_peak ? "peak SNR" : "peak SNR of the vortex";
  figure.y_label = "position error (px RMS per axis)";
  figure.log_x = figure.log_y = true;
  for (std::size_t b = 0; b < benches.size(); ++b) {
    if (benches[b].light != light) continue;
    Series series{benches[b].method.name, snrs, {}, {}};
    Series bound{fmt::format("bound, charge {}", benches[b].method.charge),
                 snrs,
                 {},
                 {},
                 Series::Style::line};
    for (std::size_t s = 0; s < snrs.size(); ++s) {
      const Row& row = rows[b * snrs.size() + s];
      series.y.push_back(row.rms_px.value);
      series.error.push_back(row.rms_px.standard_error);
      bound.y.push_back(row.bound_px);
    }
    figure.series.push_back(std::move(series));
    if (benches[b].method.tracking.tracker == TrackerKind::fit) {
      figure.series.push_back(std::move(bound));
    }
  }
  return figure;
}

}  // namespace

Findings trackers(const Settings& settings) {
  const std::vector<double> snrs = settings.quick
                                       ? std::vector<double>{3.0, 8.0, 22.0}
                                       : std::vector<double>{2.0, 3.0, 4.0, 5.0, 8.0, 12.0, 22.0};
  const int realisations = settings.quick ? 100 : 1000;
  const std::vector<SpotBench> benches = all_spot_benches();
  std::vector<Row> rows(benches.size() * snrs.size());
  parallel_for("trackers", rows.size(), settings.threads, [&](std::size_t k) {
    const SpotBench& bench = benches[k / snrs.size()];
    const double read_noise_e = read_noise_of_snr(snrs[k % snrs.size()]);
    const Cloud cloud = cloud_of(bench, read_noise_e, realisations, settings.seed + 1000 * k);
    rows[k] = {root_of(cloud.squares_px2), bound_px(bench, read_noise_e), cloud.lost};
  });
  nlohmann::json summary{{"study", "trackers"},
                         {"unit", "px RMS per axis"},
                         {"peak_e", kPeakE},
                         {"realisations", realisations},
                         {"rows", nlohmann::json::array()}};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    summary["rows"].push_back(json_of(benches[k / snrs.size()], snrs[k % snrs.size()], rows[k]));
  }
  return {std::move(summary),
          {figure_of(Light::equal_peak, benches, snrs, rows),
           figure_of(Light::equal_photons, benches, snrs, rows)}};
}

}  // namespace ovws::study
