/// Study of the position errors of one spot against read noise, as in the paper's figure
/// "Localization precision".
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <memory>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

using nlohmann::json;

constexpr double kCloudNoiseE = 55.0;  ///< read noise of the point clouds

/// One series per method at this light level. After the last method of each charge, the charge's
/// Cramer-Rao bound.
Figure sweep_figure(Light light, const std::vector<SpotBench>& benches, const Rows& rows) {
  Figure figure{std::string("localisation") + suffix_of(light),
                "Localisation of one spot at " + name_of(light), "read noise (electrons RMS)",
                "position error (px RMS per axis)"};
  figure.log_y = true;
  for (std::size_t b = 0; b < benches.size(); ++b) {
    if (benches[b].light != light) continue;
    const Method& method = benches[b].method;
    const Rows of_method = rows_with(rows, {{"light", light}, {"method", method.name}});
    figure.add(
        series_of({.name = method.name}, of_method, "read_noise_e", "rms_px", "standard_error_px"));
    const bool more = b + 1 < benches.size() && benches[b + 1].light == light &&
                      benches[b + 1].method.charge == method.charge;
    if (more) continue;
    figure.add(series_of(
        {.name = fmt::format("bound, charge {}", method.charge), .style = Series::Style::line},
        of_method, "read_noise_e", "bound_px"));
  }
  return figure;
}

/// `clouds`: one for each of the first benches.
Figure cloud_figure(const std::vector<SpotBench>& benches, const Rows& clouds) {
  Figure figure{
      "localisation-clouds",
      fmt::format("Position errors of one spot, read noise {} e, peak {} e", kCloudNoiseE, kPeakE),
      "x error (px)", "y error (px)"};
  figure.same_scale = true;
  for (std::size_t c = 0; c < clouds.size(); ++c) {
    figure.series.push_back({benches[c].method.name,
                             clouds[c].at("x_px").get<std::vector<double>>(),
                             clouds[c].at("y_px").get<std::vector<double>>(),
                             {},
                             Series::Style::points});
  }
  return figure;
}

}  // namespace

/// Its items: the rows of the table, then a cloud for each bench at equal peak, which are the first
/// benches.
Work localisation(const Settings& settings) {
  const int realisations = settings.quick ? 30 : 100;
  const auto benches = std::make_shared<const std::vector<SpotBench>>(all_spot_benches());
  std::vector<double> noises_e;
  for (double e = 5.0; e <= 85.0; e += settings.quick ? 40.0 : 10.0) noises_e.push_back(e);
  Rows conditions;
  for (const SpotBench& bench : *benches) {
    for (const double noise_e : noises_e) {
      conditions.push_back({{"light", bench.light},
                            {"method", bench.method.name},
                            {"read_noise_e", noise_e},
                            {"snr", snr_of_read_noise(noise_e)}});
    }
  }
  const std::size_t count = conditions.size();
  const auto measure = [=, seed = settings.seed](std::size_t k) -> json {
    if (k >= count) {
      const Cloud cloud = cloud_of((*benches)[k - count], kCloudNoiseE, realisations, seed);
      return {{"x_px", cloud.x_px}, {"y_px", cloud.y_px}};
    }
    const SpotBench& bench = (*benches)[k / noises_e.size()];
    const double noise_e = noises_e[k % noises_e.size()];
    const Cloud cloud = cloud_of(bench, noise_e, realisations, seed + 1000 * k);
    const Mean rms_px = root_of(cloud.squares_px2);
    return {{"rms_px", rms_px.value},
            {"standard_error_px", rms_px.standard_error},
            {"bound_px", bound_px(bench, noise_e)},
            {"lost", cloud.lost}};
  };
  const auto find = [=](const std::vector<json>& results) {
    const Rows rows = rows_of(conditions, results);
    const Rows clouds(results.begin() + std::ptrdiff_t(count), results.end());
    return Findings{
        {{"study", "localisation"},
         {"unit", "px RMS per axis"},
         {"peak_e", kPeakE},
         {"realisations", realisations},
         {"rows", rows}},
        {sweep_figure(Light::equal_peak, *benches, rows),
         sweep_figure(Light::equal_photons, *benches, rows), cloud_figure(*benches, clouds)}};
  };
  const auto at_equal_peak = std::ranges::count(*benches, Light::equal_peak, &SpotBench::light);
  return {count + std::size_t(at_equal_peak), measure, find};
}

}  // namespace ovws::study
