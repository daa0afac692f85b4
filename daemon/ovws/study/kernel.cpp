/// Study `kernel`: the best radius of the LG kernel as a function of SNR.
#include <spdlog/fmt/fmt.h>

#include <memory>

#include "daemon/ovws/study/cloud.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

/// One charge at one light level, with a spot for each kernel radius.
struct Beam {
  Light light;
  int charge;
  std::vector<SpotBench> benches;
};

/// Result for one beam, SNR and radius.
struct KernelPoint {
  Mean rms_px;
  int lost = 0;
  double bound_px = kUnknown;  ///< known for the first radius only, because all have the same
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(KernelPoint, rms_px, lost, bound_px)

struct KernelLevels {
  std::vector<double> snrs, radii;  ///< radii: units of lambda/d
  int realisations;
};

/// Errors against the kernel radius for one beam at one SNR; one value per radius.
struct Curve {
  const Beam* beam;
  double snr;
  std::vector<Mean> rms_px;
  std::vector<int> lost;
  double bound_px;  ///< does not depend on the radius
};

/// Index of the best kernel radius. A radius that loses more than 1 % of the spots ranks last,
/// because its error comes from the easy spots only.
std::size_t best_radius(const Curve& curve) {
  const auto rank = [&](std::size_t r) {
    const Mean& rms_px = curve.rms_px[r];
    const bool loses = 100.0 * curve.lost[r] > double(rms_px.count) + curve.lost[r];
    return std::pair(loses, rms_px.value);
  };
  std::size_t best = 0;
  for (std::size_t r = 1; r < curve.rms_px.size(); ++r) {
    if (rank(r) < rank(best)) best = r;
  }
  return best;
}

std::vector<Beam> beams_of(const std::vector<double>& radii) {
  const auto vortex = model_of(default_bench(), 1);
  const auto bright = model_of(default_bench(), 0);
  std::vector<Beam> beams;
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    for (const int charge : {1, 0}) {
      Beam beam{light, charge, {}};
      for (const double radius : radii) {
        const Method method{fmt::format("radius {}", radius), charge, {TrackerKind::lg, radius}};
        beam.benches.push_back(spot_bench(method, light, charge == 0 ? bright : vortex, vortex));
      }
      beams.push_back(std::move(beam));
    }
  }
  return beams;
}

/// Measures item k: one radius of one beam at one SNR. All radii see the same noise (common random
/// numbers), so that curves differ only by the radius.
KernelPoint kernel_point(std::size_t k, const std::vector<Beam>& beams, const KernelLevels& levels,
                         std::uint64_t seed) {
  const std::size_t radii = levels.radii.size(), snrs = levels.snrs.size();
  const Beam& beam = beams[k / radii / snrs];
  const std::size_t s = k / radii % snrs;
  const SpotBench& bench = beam.benches[k % radii];
  const double read_noise_e = read_noise_of_snr(levels.snrs[s]);
  const Cloud cloud =
      cloud_of(bench, read_noise_e, levels.realisations, seed + 1000 * s + unsigned(beam.charge));
  return {root_of(cloud.squares_px2), cloud.lost,
          k % radii == 0 ? bound_px(bench, read_noise_e) : kUnknown};
}

/// Curves of all beams and SNRs.
std::vector<Curve> curves_of(const std::vector<Beam>& beams, const KernelLevels& levels,
                             const std::vector<KernelPoint>& points) {
  const std::size_t radii = levels.radii.size(), snrs = levels.snrs.size();
  std::vector<Curve> curves;
  for (std::size_t c = 0; c < beams.size() * snrs; ++c) {
    const double snr = levels.snrs[c % snrs];
    const Beam& beam = beams[c / snrs];
    Curve curve{&beam, snr, {}, {}, points[c * radii].bound_px};
    for (std::size_t r = 0; r < radii; ++r) {
      curve.rms_px.push_back(points[c * radii + r].rms_px);
      curve.lost.push_back(points[c * radii + r].lost);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

Figure kernel_figure(Light light, const std::vector<Curve>& curves,
                     const std::vector<double>& radii) {
  Figure figure{
      light == Light::equal_peak ? "kernel" : "kernel-photons",
      fmt::format("lg at {}: error against kernel radius; dashed: bounds ({})", name_of(light),
                  light == Light::equal_peak ? "peak SNR" : "peak SNR of the vortex"),
      "kernel 1/e radius (lambda/d)", "position error (px RMS per axis)"};
  figure.log_y = true;
  std::vector<Series> bounds;
  for (const Curve& curve : curves) {
    if (curve.beam->light != light) continue;
    const char* sensor = curve.beam->charge == 0 ? "Shack-Hartmann" : "vortex";
    Series series{.name = fmt::format("{}, SNR {}", sensor, curve.snr)};
    for (std::size_t r = 0; r < radii.size(); ++r) series.add(radii[r], curve.rms_px[r]);
    figure.series.push_back(std::move(series));
    Series bound{.name = fmt::format("bound, {}, SNR {}", sensor, curve.snr),
                 .x = radii,
                 .y = std::vector<double>(radii.size(), curve.bound_px),
                 .style = Series::Style::line,
                 .colour = int(figure.series.size()),
                 .in_legend = false};
    bounds.push_back(std::move(bound));
  }
  figure.series.insert(figure.series.end(), bounds.begin(), bounds.end());
  return figure;
}

nlohmann::json kernel_row(const Curve& curve, std::size_t r, const std::vector<double>& radii) {
  return {{"light", name_of(curve.beam->light)},
          {"charge", curve.beam->charge},
          {"snr", curve.snr},
          {"radius", radii[r]},
          {"rms_px", curve.rms_px[r].value},
          {"standard_error_px", curve.rms_px[r].standard_error},
          {"bound_px", curve.bound_px},
          {"lost", curve.lost[r]}};
}

Findings kernel_findings(const std::vector<Curve>& curves, const KernelLevels& levels) {
  nlohmann::json summary{{"study", "kernel"},
                         {"unit", "px RMS per axis"},
                         {"peak_e", kPeakE},
                         {"realisations", levels.realisations},
                         {"rows", nlohmann::json::array()},
                         {"best", nlohmann::json::array()}};
  for (const Curve& curve : curves) {
    for (std::size_t r = 0; r < levels.radii.size(); ++r) {
      summary["rows"].push_back(kernel_row(curve, r, levels.radii));
    }
    summary["best"].push_back(kernel_row(curve, best_radius(curve), levels.radii));
  }
  return {std::move(summary),
          {kernel_figure(Light::equal_peak, curves, levels.radii),
           kernel_figure(Light::equal_photons, curves, levels.radii)}};
}

}  // namespace

Work kernel(const Settings& settings) {
  const KernelLevels levels =
      settings.quick
          ? KernelLevels{{2.0, 5.0, 22.0}, {0.2, 0.3, 0.4, 0.6}, 100}
          : KernelLevels{
                {2.0, 5.0, 22.0}, {0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.8, 1.0}, 400};
  const auto beams = std::make_shared<const std::vector<Beam>>(beams_of(levels.radii));
  return work_of(
      beams->size() * levels.snrs.size() * levels.radii.size(),
      [=, seed = settings.seed](std::size_t k) { return kernel_point(k, *beams, levels, seed); },
      [=](const std::vector<KernelPoint>& points) {
        return kernel_findings(curves_of(*beams, levels, points), levels);
      });
}

}  // namespace ovws::study
