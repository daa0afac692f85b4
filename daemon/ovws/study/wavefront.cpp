/// Study `wavefront`: residual phase variance against SNR, as in the paper's figure.
#include <spdlog/fmt/fmt.h>

#include <memory>
#include <optional>
#include <random>
#include <span>

#include "core/wavefront/residual_variance.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/fitting.hpp"
#include "daemon/ovws/study/sensor.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

using nlohmann::json;

constexpr double kQuickSnr = 5.0;  ///< in the quick study, `fit` runs at this SNR only
constexpr int kTemplateRenderings =
    3;  ///< renderings of the templates: the first and two refreshes

struct AberrationCase {
  const char* name;
  const char* title;
  int j;
  double unit_waves;  ///< unit amplitude, as the paper's 2 lambda
  std::vector<Mode> modes() const { return {{j, unit_waves / zernike_rms_factor(j)}}; }
};
constexpr std::array<AberrationCase, 2> kAberrationCases{
    {{"astigmatism", "oblique astigmatism, 2 waves", 3, 2.0},
     {"defocus", "defocus, 2 waves", 4, 2.0}}};

struct Bench {
  const AberrationCase* aberration;
  Light light;
  Method method;
  std::shared_ptr<Measurer> measurer;
  Image<float> light_e;
  std::vector<Vec2> at_px;

  /// Whether all pixels are fitted, from the tracker's result on.
  bool fits() const { return method.tracking.tracker == TrackerKind::fit; }
};

double residual_variance(const Measurer& measurer, const std::vector<double>& found,
                         const std::vector<Mode>& truth) {
  return residual_variance_rad2(std::span(measurer.modes_j()), std::span(found), truth);
}

std::vector<SpotFix> fixes_at(const std::vector<Vec2>& positions) {
  std::vector<SpotFix> fixes(positions.size());
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    fixes[i].x = float(positions[i].x);
    fixes[i].y = float(positions[i].y);
  }
  return fixes;
}

/// Columns of a row: variances over the instances, rad^2. A row of `fit` has the Cramer-Rao bound,
/// which is independent of the method, and the others the variance without noise: the model's
/// error.
json phase_variances(const Bench& bench, double snr, int instances, std::uint64_t seed) {
  const std::vector<Mode> truth = bench.aberration->modes();
  std::mt19937_64 random(seed);
  const double reach = kStartWithin * bench.measurer->lambda_d_px();
  std::uniform_real_distribution<double> within(-reach, reach);
  const double read_noise_e = read_noise_of_snr(snr);
  std::optional<SpotRenderer> renderer;
  if (bench.fits()) {
    renderer.emplace(
        renderer_of(thousand_px_bench(), bench.method.charge, bench.measurer->modes_j()));
  }
  std::vector<double> variances;  // of each reconstructed instance
  int lost = 0;
  for (int k = 0; k < instances; ++k) {
    std::vector<Vec2> starts = bench.at_px;
    for (Vec2& start : starts) start = start + Vec2{within(random), within(random)};
    const Exposure exposure = expose(bench.light_e, read_noise_e, random());
    const auto fixes = bench.measurer->track(exposure, starts);
    for (const SpotFix& fix : fixes) lost += fix.found() ? 0 : 1;
    auto found = bench.measurer->modes(fixes);
    if (renderer) {
      found =
          fitted_waves(*renderer, exposure, read_noise_e, std::move(found), kTemplateRenderings);
    }
    if (std::isnan(found.front())) continue;
    variances.push_back(residual_variance(*bench.measurer, found, truth));
  }
  const Mean mean = mean_of(variances);
  json row{{"variance_rad2", mean.value}, {"standard_error_rad2", mean.standard_error},
           {"instances", mean.count},     {"noise_free_rad2", nullptr},
           {"bound_rad2", nullptr},       {"undetermined", instances - int(mean.count)},
           {"lost_spots", lost}};
  if (bench.fits()) {
    row["bound_rad2"] = wavefront_bound_rad2(thousand_px_bench(), bench.method.charge, truth,
                                             bench.light_e, read_noise_e);
  } else {
    row["noise_free_rad2"] =
        residual_variance(*bench.measurer, bench.measurer->modes(fixes_at(bench.at_px)), truth);
  }
  return row;
}

std::vector<Bench> aberration_benches() {
  const Geometry geometry = thousand_px_bench();
  const SensorPair sensors(geometry);
  std::vector<Bench> all;
  for (const AberrationCase& aberration : kAberrationCases) {
    for (const Light light : kLights) {
      for (const Method& method : all_methods()) {
        Bench bench{&aberration,
                    light,
                    method,
                    std::make_shared<Measurer>(geometry, method, sensors.of(method.charge)),
                    sensors.electrons(method.charge, aberration.modes(), light),
                    {}};
        bench.at_px = bench.measurer->noise_free_px(
            bench.light_e, bench.measurer->predicted_px(aberration.modes()));
        all.push_back(std::move(bench));
      }
    }
  }
  return all;
}

/// One series per method, and the bound of each charge after `fit`.
Figure variance_figure(const AberrationCase& aberration, Light light, const Rows& rows) {
  Figure figure{fmt::format("wavefront-{}{}", aberration.name, suffix_of(light)),
                fmt::format("{} over 1000 px, {}", aberration.title, name_of(light)), "peak SNR",
                "mean residual phase variance (rad^2)"};
  figure.log_y = true;
  const Rows seen = rows_with(rows, {{"aberration", aberration.name}, {"light", light}});
  for (const Method& method : all_methods()) {
    const Rows of_method = rows_with(seen, {{"method", method.name}});
    figure.add(
        series_of({.name = method.name}, of_method, "snr", "variance_rad2", "standard_error_rad2"));
    figure.add(series_of(
        {.name = fmt::format("bound, charge {}", method.charge), .style = Series::Style::line},
        of_method, "snr", "bound_rad2"));
  }
  return figure;
}

}  // namespace

Work wavefront(const Settings& settings) {
  const std::vector<double> snrs =
      settings.quick ? std::vector<double>{2.0, 5.0, 22.0}
                     : std::vector<double>{2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 14.0, 18.0, 22.0};
  const int instances = settings.quick ? 30 : 100;
  const auto all = std::make_shared<const std::vector<Bench>>(aberration_benches());
  Rows conditions;
  std::vector<std::size_t> numbers;  // of the rows' random number streams
  for (std::size_t k = 0; k < all->size() * snrs.size(); ++k) {
    const Bench& bench = (*all)[k / snrs.size()];
    const double snr = snrs[k % snrs.size()];
    if (bench.fits() && settings.quick && snr != kQuickSnr) continue;
    numbers.push_back(k);
    conditions.push_back({{"aberration", bench.aberration->name},
                          {"light", bench.light},
                          {"method", bench.method.name},
                          {"snr", snr}});
  }
  const auto measure = [=, seed = settings.seed](std::size_t row) {
    const std::size_t k = numbers[row];
    return phase_variances((*all)[k / snrs.size()], snrs[k % snrs.size()], instances,
                           seed + 1000 * k);
  };
  const auto draw = [](const Rows& rows, Findings& found) {
    for (const AberrationCase& aberration : kAberrationCases) {
      for (const Light light : kLights) {
        found.figures.push_back(variance_figure(aberration, light, rows));
      }
    }
  };
  return work_of(
      {{{"study", "wavefront"}, {"unit", "rad^2"}, {"peak_e", kPeakE}, {"instances", instances}},
       conditions,
       measure,
       draw});
}

}  // namespace ovws::study
