/// Study `scintillation`: residual phase variance against the number of subapertures, for several
/// strengths of scintillation at equal light.
#include <spdlog/fmt/fmt.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/lattice_bench.hpp"
#include "daemon/ovws/study/mode_bench.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

using nlohmann::json;

constexpr double kPupilsPerR0 = 6.0;
constexpr std::array<int, 5> kAcross{5, 6, 7, 9, 13};  ///< 13, 21, 29, 49 and 113 subapertures
constexpr std::array<double, 2> kLightE{10.0 * kPhotonsE, kPhotonsE};
constexpr std::array<SpotMethod, 3> kMethods{{{"bright, centroid of a fixed cell", 0, true},
                                              {"bright, lg", 0, false},
                                              {"vortex, lg", 1, false}}};
constexpr double kConfidence = 1.96;  ///< standard errors of a 95 % interval

struct TurbulenceLevels {
  std::vector<double> rytov;
  int waves;  ///< of every strength
};

using Benches = std::vector<std::unique_ptr<const LatticeBench>>;

/// Index of the bench of a lattice and a method.
std::size_t bench_at(std::size_t lattice, std::size_t method) {
  return lattice * kMethods.size() + method;
}

/// Zernike modes j = 1, 2, … at the pixels of pupil_pixels(), rad per wave.
Eigen::MatrixXf modes_at_pixels(int count) {
  const auto pixels = pupil_pixels();
  Eigen::MatrixXf modes(Eigen::Index(pixels.size()), count);
  std::vector<double> values(std::size_t(count) + 1);
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    zernike_values(pixels[p].at, values);
    for (int j = 1; j <= count; ++j) {
      modes(Eigen::Index(p), j - 1) = float(2.0 * std::numbers::pi * values[std::size_t(j)]);
    }
  }
  return modes;
}

/// Variance of the phase that the modes `waves` leave, weighted by intensity. The phase counts from
/// its mean, between -pi and pi: at branch points there is no other.
double residual_rad2(const Wave& wave, const Eigen::MatrixXf& modes,
                     const std::vector<float>& waves) {
  const auto pixels = pupil_pixels();
  Eigen::VectorXf phase = Eigen::VectorXf::Zero(Eigen::Index(pixels.size()));
  if (!waves.empty()) {
    const auto count = Eigen::Index(waves.size());
    phase = modes.leftCols(count) * Eigen::Map<const Eigen::VectorXf>(waves.data(), count);
  }
  std::vector<std::complex<double>> left;
  std::complex<double> mean = 0.0;
  double light = 0.0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const std::complex<float> at = wave.at(pixels[p].x, pixels[p].y);
    left.push_back(std::complex<double>(at * std::polar(1.0F, -phase[Eigen::Index(p)])));
    mean += left.back() * std::abs(left.back());
    light += std::norm(left.back());
  }
  double sum = 0.0;
  for (const std::complex<double>& at : left) {
    const double angle = std::arg(at * std::conj(mean));
    sum += std::norm(at) * angle * angle;
  }
  return sum / light;
}

/// One wave: what each bench leaves of it at each light level, rad^2. `index`: scintillation index;
/// by light x bench: `residuals` for each number of modes, `lost` fraction of spots,
/// `undetermined`: 1 if no modes were found.
json look_at(const Wave& wave, const Benches& benches, const Eigen::MatrixXf& modes,
             std::uint64_t seed) {
  const double uncorrected = residual_rad2(wave, modes, {});
  json seen{{"index", scintillation_index(wave)}};
  for (const double light_e : kLightE) {
    for (const auto& bench : benches) {
      const LatticeFrame frame = bench->measure(wave, light_e, ++seed);
      std::vector<double> residuals;
      for (const auto& waves : frame.waves) {
        const bool found = !std::isnan(waves.front());
        residuals.push_back(found ? residual_rad2(wave, modes, waves) : uncorrected);
      }
      seen["residuals"].push_back(std::move(residuals));
      seen["lost"].push_back(double(frame.lost) / bench->subapertures());
      seen["undetermined"].push_back(std::isnan(frame.waves.front().front()) ? 1 : 0);
    }
  }
  return seen;
}

/// What one bench leaves at one light level and strength, with its best number of modes.
struct Row {
  std::size_t light, lattice, method;
  int modes;
  std::vector<double> residuals;  ///< of every wave
  Mean mean;
  double lost;
  int undetermined;
};

Row method_row(std::size_t light, std::size_t lattice, std::size_t method, const Benches& benches,
               const Rows& seen) {
  const std::size_t bench = bench_at(lattice, method), at = light * benches.size() + bench;
  Row row{light, lattice, method, 0, {}, {}, 0.0, 0};
  const auto& counts = benches[bench]->mode_counts();
  for (std::size_t k = 0; k < counts.size(); ++k) {
    std::vector<double> residuals;
    for (const json& one : seen)
      residuals.push_back(one.at("residuals").at(at).at(k).get<double>());
    const Mean mean = mean_of(residuals);
    if (row.modes != 0 && mean.value >= row.mean.value) continue;
    row.modes = counts[k];
    row.mean = mean;
    row.residuals = std::move(residuals);
  }
  for (const json& one : seen) {
    row.lost += one.at("lost").at(at).get<double>() / double(seen.size());
    row.undetermined += one.at("undetermined").at(at).get<int>();
  }
  return row;
}

/// How much less variance `one` leaves than `other` on the same waves, and its standard error.
Mean reduction(const Row& one, const Row& other) {
  const double ratio = one.mean.value / other.mean.value;
  std::vector<double> deviations;
  for (std::size_t k = 0; k < one.residuals.size(); ++k) {
    deviations.push_back((one.residuals[k] - ratio * other.residuals[k]) / other.mean.value);
  }
  Mean found = mean_of(deviations);
  found.value = 1.0 - ratio;
  return found;
}

json row_json(const Row& row, double rytov, const Mean& index, const Benches& benches,
              const Row& finest) {
  const Mean less = reduction(row, finest);
  return {{"rytov_variance", rytov},
          {"scintillation_index", index.value},
          {"light_e", kLightE[row.light]},
          {"method", kMethods[row.method].name},
          {"charge", kMethods[row.method].charge},
          {"subapertures", benches[bench_at(row.lattice, row.method)]->subapertures()},
          {"modes", row.modes},
          {"residual_rad2", row.mean.value},
          {"residual_from_rad2", row.mean.value - kConfidence * row.mean.standard_error},
          {"residual_to_rad2", row.mean.value + kConfidence * row.mean.standard_error},
          {"below_finest", less.value},
          {"below_finest_standard_error", less.standard_error},
          {"lost_fraction", row.lost},
          {"undetermined", row.undetermined},
          {"waves", row.mean.count}};
}

const Row& least(const std::vector<Row>& rows) {
  return *std::min_element(rows.begin(), rows.end(),
                           [](const Row& a, const Row& b) { return a.mean.value < b.mean.value; });
}

/// Adds the lattices of one method at one light level and strength, the finest last.
void add_rows(const std::vector<Row>& rows, double rytov, const Mean& index, const Benches& benches,
              json& summary) {
  const auto compared = [&](const Row& row) {
    return row_json(row, rytov, index, benches, rows.back());
  };
  for (const Row& row : rows) summary["rows"].push_back(compared(row));
  summary["best"].push_back(compared(least(rows)));
}

Figure rytov_figure(std::size_t light) {
  Figure figure{fmt::format("scintillation-{}", light == 0 ? "bright" : "dim"),
                fmt::format("D/r0 = {:.0f}, {:.0f} electrons over the pupil, best number of modes",
                            kPupilsPerR0, kLightE[light]),
                "Rytov variance", "residual phase variance (rad^2)"};
  figure.log_y = true;
  return figure;
}

Findings scintillation_findings(const TurbulenceLevels& levels, const Benches& benches,
                                const Rows& all) {
  Findings findings;
  findings.summary = {{"study", "scintillation"},      {"unit", "rad^2"},
                      {"pupils_per_r0", kPupilsPerR0}, {"read_noise_e", 5.0},
                      {"rows", json::array()},         {"best", json::array()}};
  for (std::size_t light = 0; light < kLightE.size(); ++light) {
    Figure figure = rytov_figure(light);
    for (std::size_t method = 0; method < kMethods.size(); ++method) {
      std::vector<Series> series(kAcross.size());
      for (std::size_t s = 0; s < levels.rytov.size(); ++s) {
        const auto first = all.begin() + std::ptrdiff_t(s) * levels.waves;
        const Rows seen(first, first + levels.waves);
        std::vector<double> indices;
        for (const json& one : seen) indices.push_back(one.at("index").get<double>());
        std::vector<Row> rows;
        for (std::size_t lattice = 0; lattice < kAcross.size(); ++lattice) {
          rows.push_back(method_row(light, lattice, method, benches, seen));
          series[lattice].name = fmt::format("{}, {}", kMethods[method].name,
                                             benches[bench_at(lattice, method)]->subapertures());
          series[lattice].add(levels.rytov[s], rows.back().mean);
        }
        add_rows(rows, levels.rytov[s], mean_of(indices), benches, findings.summary);
      }
      for (Series& one : series) figure.series.push_back(std::move(one));
    }
    findings.figures.push_back(std::move(figure));
  }
  return findings;
}

std::shared_ptr<const Benches> lattice_benches() {
  auto all = std::make_shared<Benches>();
  for (const int across : kAcross) {
    for (const SpotMethod& method : kMethods) {
      all->push_back(std::make_unique<const LatticeBench>(across, method));
    }
  }
  return all;
}

}  // namespace

Work scintillation(const Settings& settings) {
  const TurbulenceLevels levels = settings.quick
                                      ? TurbulenceLevels{{0.0, 0.1, 1.0}, 8}
                                      : TurbulenceLevels{{0.0, 0.1, 0.3, 1.0, 2.0, 4.0}, 100};
  const auto all = lattice_benches();
  const auto modes = std::make_shared<const Eigen::MatrixXf>(modes_at_pixels(44));
  const auto measure = [=, seed = settings.seed](std::size_t k) {
    const double rytov = levels.rytov[k / std::size_t(levels.waves)];
    const std::size_t wave = k % std::size_t(levels.waves);  // the same air at every distance
    return look_at(scintillated_wave({kPupilsPerR0, rytov}, seed + 1000 * wave), *all, *modes,
                   seed + 1000 * k);
  };
  return {levels.rytov.size() * std::size_t(levels.waves), measure,
          [=](const Rows& seen) { return scintillation_findings(levels, *all, seen); }};
}

}  // namespace ovws::study
