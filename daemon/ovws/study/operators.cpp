/// Study `operators`: the errors of all reconstruction operators on the same images, without and
/// with noise.
#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <memory>

#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/operator_bench.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kSnr = 22.0;

/// A charge at one light level, with or without noise; noise-free only at equal peak.
struct OperatorCase {
  int charge;
  Light light;
  bool noisy;
};
constexpr std::array<OperatorCase, 5> kOperatorCases{{{1, Light::equal_peak, false},
                                                      {0, Light::equal_peak, false},
                                                      {1, Light::equal_peak, true},
                                                      {0, Light::equal_peak, true},
                                                      {0, Light::equal_photons, true}}};

struct OperatorLevels {
  std::vector<double> amplitudes;  ///< waves RMS; figures show the last one
  std::vector<int> modes_j;
  int realisations;
  Mode mode(std::size_t k) const {
    return {modes_j[k % modes_j.size()], amplitudes[k / modes_j.size()]};
  }
  std::size_t modes() const { return modes_j.size() * amplitudes.size(); }
};

/// Results for one case and one mode.
struct OperatorErrors {
  std::array<Mean, kOperatorCount> errors_waves;
  std::array<int, kOperatorCount> undetermined{};
  double bound_waves = 0.0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(OperatorErrors, errors_waves, undetermined, bound_waves)

/// Sum of squares over all modes of measured minus true, waves^2.
double square_error(const std::vector<double>& found, const std::vector<int>& modes_j, Mode truth) {
  double squares = 0.0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double error = found[k] - (truth.j == modes_j[k] ? truth.waves : 0.0);
    squares += error * error;
  }
  return squares;
}

OperatorErrors operator_errors(OperatorBench& bench, const std::vector<int>& modes_j,
                               const OperatorCase& one, Mode mode, int realisations,
                               std::uint64_t seed) {
  const std::vector<Mode> modes{mode};
  const double read_noise_e = one.noisy ? read_noise_of_snr(kSnr) : 0.0;
  const Image<float> light_e = bench.light_e(modes, one.light);
  OperatorErrors outcome;
  if (one.noisy) outcome.bound_waves = bench.bound_waves(light_e, modes, read_noise_e);
  std::array<std::vector<double>, kOperatorCount> squares;
  for (int r = 0; r < (one.noisy ? realisations : 1); ++r) {
    const Readings readings = bench.read(light_e, modes, read_noise_e, seed + unsigned(r));
    for (std::size_t o = 0; o < kOperatorCount; ++o) {
      const double square = square_error(readings[o], modes_j, mode);
      std::isnan(square) ? void(++outcome.undetermined[o]) : squares[o].push_back(square);
    }
  }
  for (std::size_t o = 0; o < kOperatorCount; ++o) outcome.errors_waves[o] = root_of(squares[o]);
  return outcome;
}

Figure frame_of(const OperatorCase& one, double waves) {
  const std::string mode = fmt::format("single modes at {} wave", waves);
  Figure figure;
  if (!one.noisy) {
    figure.name = one.charge == 0 ? "operators-shack-hartmann-noise-free" : "operators-noise-free";
    figure.title = fmt::format("{}, {}, no noise",
                               one.charge == 0 ? "Shack-Hartmann spots" : "Vortices", mode);
  } else if (one.charge == 1) {
    figure.name = "operators";
    figure.title = fmt::format("Vortices, {}, peak SNR {} (the same at equal photons)", mode, kSnr);
  } else {
    figure.name = one.light == Light::equal_peak ? "operators-shack-hartmann"
                                                 : "operators-shack-hartmann-photons";
    figure.title = fmt::format("Shack-Hartmann spots, {}, read noise of SNR {}, {}", mode, kSnr,
                               name_of(one.light));
  }
  figure.x_label = "OSA index j of the mode shown";
  figure.y_label = "error: root sum square of all modes (waves RMS)";
  figure.x_step = 1.0;
  figure.log_y = true;
  return figure;
}

Figure operator_figure(std::size_t c, const OperatorLevels& levels,
                       const std::vector<OperatorErrors>& outcomes) {
  const OperatorCase& one = kOperatorCases[c];
  Figure figure = frame_of(one, levels.amplitudes.back());
  const OperatorNames names = operator_names(one.charge);
  Series bound{"bound of all pixels", {}, {}, {}, Series::Style::line};
  for (std::size_t o = 0; o < kOperatorCount; ++o) {
    Series series{names[o], {}, {}, {}};
    for (std::size_t m = levels.modes() - levels.modes_j.size(); m < levels.modes(); ++m) {
      const OperatorErrors& outcome = outcomes[c * levels.modes() + m];
      series.x.push_back(levels.mode(m).j);
      series.y.push_back(outcome.errors_waves[o].value);
      if (one.noisy) series.error.push_back(outcome.errors_waves[o].standard_error);
      if (o == 0) bound.y.push_back(outcome.bound_waves);
    }
    bound.x = series.x;
    figure.series.push_back(std::move(series));
  }
  if (one.noisy) figure.series.push_back(std::move(bound));
  return figure;
}

nlohmann::json operator_rows(const OperatorLevels& levels,
                             const std::vector<OperatorErrors>& outcomes) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t k = 0; k < outcomes.size(); ++k) {
    const OperatorCase& one = kOperatorCases[k / levels.modes()];
    const Mode mode = levels.mode(k % levels.modes());
    const OperatorNames names = operator_names(one.charge);
    for (std::size_t o = 0; o < kOperatorCount; ++o) {
      rows.push_back({{"charge", one.charge},
                      {"light", name_of(one.light)},
                      {"noisy", one.noisy},
                      {"operator", names[o]},
                      {"j", mode.j},
                      {"waves", mode.waves},
                      {"error_waves", outcomes[k].errors_waves[o].value},
                      {"standard_error_waves", outcomes[k].errors_waves[o].standard_error},
                      {"bound_waves", outcomes[k].bound_waves},
                      {"undetermined", outcomes[k].undetermined[o]}});
    }
  }
  return rows;
}

Findings operators_findings(const OperatorLevels& levels,
                            const std::vector<OperatorErrors>& outcomes) {
  nlohmann::json summary{{"study", "operators"},
                         {"unit", "waves, root sum square over all modes"},
                         {"snr", kSnr},
                         {"peak_e", kPeakE},
                         {"realisations", levels.realisations},
                         {"rows", operator_rows(levels, outcomes)}};
  std::vector<Figure> figures;
  for (std::size_t c = 0; c < kOperatorCases.size(); ++c) {
    figures.push_back(operator_figure(c, levels, outcomes));
  }
  return {std::move(summary), std::move(figures)};
}

}  // namespace

/// Its items: every mode for each case, in the order of kOperatorCases.
Work operators(const Settings& settings) {
  const OperatorLevels levels =
      settings.quick
          ? OperatorLevels{{0.3}, {3, 13}, 2}
          : OperatorLevels{
                {0.1, 0.3}, {3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18}, 4};
  const auto vortex = std::make_shared<const OperatorTools>(1);
  const auto bright = std::make_shared<const OperatorTools>(0);
  return work_of(
      kOperatorCases.size() * levels.modes(),
      [levels, vortex, bright, seed = settings.seed](std::size_t k) {
        const OperatorCase& one = kOperatorCases[k / levels.modes()];
        const OperatorTools& with = one.charge == 0 ? *bright : *vortex;
        OperatorBench bench(with);
        return operator_errors(bench, with.modes_j(), one, levels.mode(k % levels.modes()),
                               levels.realisations, seed + 1000 * k);
      },
      [levels](const std::vector<OperatorErrors>& outcomes) {
        return operators_findings(levels, outcomes);
      });
}

}  // namespace ovws::study
