/// Every tracker against the Cramer-Rao bound.
#include <spdlog/fmt/fmt.h>

#include <cmath>

#include "core/tracking/localisation_bound.hpp"
#include "daemon/study/cloud.hpp"
#include "daemon/study/figure.hpp"
#include "daemon/study/parallel.hpp"
#include "daemon/study/statistics.hpp"
#include "daemon/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr int kBoundHalfPx = 26;

/// A picture as a shape, for positions that are whole pixels from its centre.
class PictureShape final : public SpotShape {
 public:
  PictureShape(const Image<float>& picture, int x, int y) : picture_(picture), x_(x), y_(y) {}
  ShapeSample at(Vec2 from_centre) const override {
    const int x = x_ + int(std::lround(from_centre.x));
    const int y = y_ + int(std::lround(from_centre.y));
    const auto value = [&](int dx, int dy) { return double(picture_.at(x + dx, y + dy)); };
    // Fourth-order central differences: the light has no detail finer than lambda/d.
    return {value(0, 0), (8.0 * (value(1, 0) - value(-1, 0)) - (value(2, 0) - value(-2, 0))) / 12.0,
            (8.0 * (value(0, 1) - value(0, -1)) - (value(0, 2) - value(0, -2))) / 12.0};
  }

 private:
  const Image<float>& picture_;
  int x_, y_;
};

/// The bound of the very spot that is tracked, with its ripple, up to half the way to its
/// neighbours.
double bound_px(const SpotBench& bench, double read_noise_e) {
  const int x = int(std::lround(bench.at_px.x)), y = int(std::lround(bench.at_px.y));
  const PictureShape shape(bench.electrons_px, x, y);
  return localisation_bound(shape, {double(x), double(y)}, kBoundHalfPx, {1.0, 0.0, read_noise_e})
      .px;
}

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
  figure.x_label = "peak SNR";
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
    if (benches[b].method.tracking.tracker == TrackerKind::matched) {
      figure.series.push_back(std::move(bound));
    }
  }
  return figure;
}

}  // namespace

Summary trackers(const Settings& settings) {
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
  for (const Light light : {Light::equal_peak, Light::equal_photons}) {
    const Figure figure = figure_of(light, benches, snrs, rows);
    if (auto done = write_figure(figure, settings.folder); !done) return fail(done.error());
  }
  return summary;
}

}  // namespace ovws::study
