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
#include "daemon/ovws/study/wavefront_bound.hpp"

namespace ovws::study {
namespace {

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

/// Second measuring step, which starts from the tracker's result.
enum class Then { nothing, fit };

struct Bench {
  const AberrationCase* aberration;
  Light light;
  Method method;
  Then then = Then::nothing;
  std::shared_ptr<Measurer> measurer;
  Image<float> light_e;
  std::vector<Vec2> at_px;
};

struct PhaseVariances {
  std::vector<double> variances;  ///< rad^2, one per reconstructed instance
  int undetermined = 0;
  int lost = 0;                  ///< number of lost spots
  double bound_rad2 = 0.0;       ///< independent of the method; reported with `fit`
  double noise_free_rad2 = 0.0;  ///< residual variance without noise: the model's error
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PhaseVariances, variances, undetermined, lost, bound_rad2,
                                   noise_free_rad2)

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

PhaseVariances phase_variances(const Bench& bench, double snr, int instances, std::uint64_t seed) {
  PhaseVariances outcome;
  if (bench.then == Then::nothing) {
    outcome.noise_free_rad2 = residual_variance(
        *bench.measurer, bench.measurer->modes(fixes_at(bench.at_px)), bench.aberration->modes());
  }
  std::mt19937_64 random(seed);
  const double reach = kStartWithin * bench.measurer->lambda_d_px();
  std::uniform_real_distribution<double> within(-reach, reach);
  const int charge = bench.method.charge;
  const std::vector<int>& modes_j = bench.measurer->modes_j();
  const double read_noise_e = read_noise_of_snr(snr);
  std::optional<SpotRenderer> renderer;
  if (bench.then == Then::fit) renderer.emplace(renderer_of(thousand_px_bench(), charge, modes_j));
  for (int k = 0; k < instances; ++k) {
    std::vector<Vec2> starts = bench.at_px;
    for (Vec2& start : starts) start = start + Vec2{within(random), within(random)};
    const Exposure exposure = expose(bench.light_e, read_noise_e, random());
    const auto fixes = bench.measurer->track(exposure, starts);
    for (const SpotFix& fix : fixes) outcome.lost += fix.found() ? 0 : 1;
    auto found = bench.measurer->modes(fixes);
    if (renderer) {
      found =
          fitted_waves(*renderer, exposure, read_noise_e, std::move(found), kTemplateRenderings);
    }
    if (std::isnan(found.front())) {
      ++outcome.undetermined;
    } else {
      outcome.variances.push_back(
          residual_variance(*bench.measurer, found, bench.aberration->modes()));
    }
  }
  return outcome;
}

std::vector<Bench> aberration_benches() {
  const Geometry geometry = thousand_px_bench();
  const auto vortex = model_of(geometry, 1);
  const auto bright = model_of(geometry, 0);
  std::vector<Bench> all;
  for (const AberrationCase& aberration : kAberrationCases) {
    for (const Light light : {Light::equal_peak, Light::equal_photons}) {
      for (const Method& method : all_methods()) {
        const bool fits = method.tracking.tracker == TrackerKind::fit;
        const auto model = method.charge == 0 ? bright : vortex;
        Bench bench{&aberration,
                    light,
                    method,
                    fits ? Then::fit : Then::nothing,
                    std::make_shared<Measurer>(geometry, method, model),
                    {},
                    {}};
        bench.light_e = electrons(*model, *vortex, aberration.modes(), light);
        bench.at_px = bench.measurer->noise_free_px(
            bench.light_e, bench.measurer->predicted_px(aberration.modes()));
        all.push_back(std::move(bench));
      }
    }
  }
  return all;
}

/// Whether the Cramer-Rao bound of this charge is reported with this bench.
bool bounded(const Bench& bench) {
  return bench.then == Then::fit;
}

nlohmann::json value_if(bool present, double value) {
  return present ? nlohmann::json(value) : nlohmann::json();
}

nlohmann::json variance_row(const Bench& bench, double snr, const Mean& variance,
                            const PhaseVariances& outcome) {
  return {{"aberration", bench.aberration->name},
          {"light", name_of(bench.light)},
          {"method", bench.method.name},
          {"snr", snr},
          {"variance_rad2", variance.value},
          {"standard_error_rad2", variance.standard_error},
          {"instances", variance.count},
          {"noise_free_rad2", value_if(bench.then == Then::nothing, outcome.noise_free_rad2)},
          {"bound_rad2", value_if(bounded(bench), outcome.bound_rad2)},
          {"undetermined", outcome.undetermined},
          {"lost_spots", outcome.lost}};
}

/// Adds the series of one bench to its figure, and its rows to `summary`.
void add_bench(const Bench& bench, const std::vector<double>& snrs,
               std::span<const PhaseVariances> outcomes, Figure& figure, nlohmann::json& summary) {
  Series series{bench.method.name, {}, {}, {}};
  for (std::size_t s = 0; s < snrs.size(); ++s) {
    const PhaseVariances& outcome = outcomes[s];
    if (outcome.variances.empty() && outcome.undetermined == 0) continue;  // SNR not measured
    const Mean variance = mean_of(outcome.variances);
    series.add(snrs[s], variance);
    summary["rows"].push_back(variance_row(bench, snrs[s], variance, outcome));
  }
  figure.series.push_back(std::move(series));
  if (!bounded(bench)) return;
  Series bound{
      fmt::format("bound, charge {}", bench.method.charge), snrs, {}, {}, Series::Style::line};
  for (const PhaseVariances& outcome : outcomes) bound.y.push_back(outcome.bound_rad2);
  figure.series.push_back(std::move(bound));
}

Findings wavefront_findings(const std::vector<Bench>& all, const std::vector<double>& snrs,
                            int instances, const std::vector<PhaseVariances>& outcomes) {
  nlohmann::json summary{{"study", "wavefront"},
                         {"unit", "rad^2"},
                         {"peak_e", kPeakE},
                         {"instances", instances},
                         {"rows", nlohmann::json::array()}};
  std::vector<Figure> figures;
  for (const AberrationCase& aberration : kAberrationCases) {
    for (const Light light : {Light::equal_peak, Light::equal_photons}) {
      Figure figure{std::string("wavefront-") + aberration.name +
                        (light == Light::equal_peak ? "" : "-photons"),
                    fmt::format("{} over 1000 px, {}", aberration.title, name_of(light)),
                    "peak SNR", "mean residual phase variance (rad^2)"};
      figure.log_y = true;
      for (std::size_t b = 0; b < all.size(); ++b) {
        if (all[b].aberration != &aberration || all[b].light != light) continue;
        add_bench(all[b], snrs, std::span(outcomes).subspan(b * snrs.size(), snrs.size()), figure,
                  summary);
      }
      figures.push_back(std::move(figure));
    }
  }
  return {std::move(summary), std::move(figures)};
}

}  // namespace

Work wavefront(const Settings& settings) {
  const std::vector<double> snrs =
      settings.quick ? std::vector<double>{2.0, 5.0, 22.0}
                     : std::vector<double>{2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 14.0, 18.0, 22.0};
  const int instances = settings.quick ? 30 : 100;
  const auto all = std::make_shared<const std::vector<Bench>>(aberration_benches());
  const auto measure_one = [=](std::size_t k) {
    const Bench& bench = (*all)[k / snrs.size()];
    const double snr = snrs[k % snrs.size()];
    if (bench.then != Then::nothing && settings.quick && snr != kQuickSnr) return PhaseVariances{};
    PhaseVariances outcome = phase_variances(bench, snr, instances, settings.seed + 1000 * k);
    if (!bounded(bench)) return outcome;
    outcome.bound_rad2 =
        wavefront_bound_rad2(thousand_px_bench(), bench.method.charge, bench.aberration->modes(),
                             bench.light_e, read_noise_of_snr(snr));
    return outcome;
  };
  return work_of(all->size() * snrs.size(), measure_one,
                 [=](const std::vector<PhaseVariances>& outcomes) {
                   return wavefront_findings(*all, snrs, instances, outcomes);
                 });
}

}  // namespace ovws::study
