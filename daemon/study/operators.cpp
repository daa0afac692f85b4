/// From slopes to modes: every operator on the same images, without noise and with it.
#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <functional>
#include <random>
#include <stdexcept>

#include "core/wavefront/diffractive_matrix.hpp"
#include "core/wavefront/refine.hpp"
#include "core/wavefront/relinearise.hpp"
#include "core/wavefront/slope_model.hpp"
#include "daemon/study/figure.hpp"
#include "daemon/study/parallel.hpp"
#include "daemon/study/sensor.hpp"
#include "daemon/study/statistics.hpp"
#include "daemon/study/studies.hpp"

namespace ovws::study {
namespace {

constexpr double kSnr = 22.0;
constexpr int kCharge = 1;
constexpr std::array<const char*, 6> kOperators{"G-tilt",      "V-tilt",       "tracker's own",
                                                "diffractive", "relinearised", "refined"};

/// What is shared by all images; a model and a refiner are for one thread at a time.
struct Tools {
  Tools();
  Geometry geometry = default_bench();
  std::shared_ptr<SensorModel> model = model_of(geometry, kCharge);
  Measurer measurer{geometry, {"matched", kCharge, {TrackerKind::matched}}, model};
  std::vector<Eigen::MatrixXd> slopes;  ///< of the linear operators, in the order of kOperators
};

Tools::Tools() {
  SensorConfig sensor = geometry.sensor;
  sensor.charge = kCharge;
  const auto& modes_j = measurer.modes_j();
  for (const SlopeModel& kind :
       {SlopeModel(SlopeKind::gradient_tilt), SlopeModel(SlopeKind::vortex_tilt),
        slope_model(kCharge, measurer.method().tracking)}) {
    slopes.push_back(slope_matrix(model->lattice(), sensor, modes_j, kind, model->px_per_cycle()));
  }
  auto matrix = diffractive_matrix(*model, sensor, measurer.tracker(), modes_j);
  if (!matrix) throw std::logic_error(matrix.error().reason);
  slopes.push_back(matrix->slopes);
}

/// One wavefront, as every operator reads it; NaN where one has no answer.
using Readings = std::array<std::vector<double>, kOperators.size()>;

class Bench {
 public:
  explicit Bench(const Tools& tools) : tools_(tools), model_(model_of(tools.geometry, kCharge)) {
    SensorConfig sensor = tools.geometry.sensor;
    sensor.charge = kCharge;
    sensor_ = sensor;
    auto refiner = Refiner::make(sensor, tools.geometry.slm, tools.geometry.optics, 512, 512,
                                 tools.measurer.modes_j());
    if (!refiner) throw std::logic_error(refiner.error().reason);
    refiner_ = std::make_unique<Refiner>(std::move(*refiner));
  }

  /// With no read noise there is no shot noise either.
  Readings read(const std::vector<Mode>& modes, double read_noise_e, std::uint64_t seed) {
    const Image<float> light = electrons(*model_, *model_, modes, Light::equal_peak);
    const Exposure exposure =
        read_noise_e > 0.0 ? expose(light, read_noise_e, seed) : noise_free(light);
    const auto fixes = tools_.measurer.track(exposure, tools_.measurer.predicted_px(modes));
    Readings readings;
    for (std::size_t k = 0; k < tools_.slopes.size(); ++k) {
      readings[k] = linear(tools_.slopes[k], fixes);
    }
    readings[4] = relinearised(fixes, readings[2]);
    readings[5] = refined(exposure, read_noise_e, readings[2]);
    return readings;
  }

 private:
  std::vector<double> linear(const Eigen::MatrixXd& slopes, std::span<const SpotFix> fixes) const {
    const Reconstructor reconstructor(slopes, tools_.measurer.modes_j(),
                                      tools_.measurer.reference_px());
    Reconstructor::Scratch scratch = reconstructor.make_scratch();
    std::vector<float> waves(tools_.measurer.modes_j().size());
    reconstructor.solve(fixes, scratch, waves);
    return {waves.begin(), waves.end()};
  }

  std::vector<double> relinearised(std::span<const SpotFix> fixes,
                                   const std::vector<double>& start) {
    const std::vector<float> from(start.begin(), start.end());
    const auto done = relinearise(*model_, sensor_, tools_.measurer.tracker(), tools_.slopes[2],
                                  tools_.measurer.modes_j(), fixes, from);
    return done ? done->waves : std::vector<double>(start.size(), NAN);
  }

  std::vector<double> refined(const Exposure& exposure, double read_noise_e,
                              const std::vector<double>& start) {
    const double rounding_e = 0.3 / exposure.dn_per_e;
    const RefineCamera camera{1.0 / exposure.dn_per_e, std::hypot(read_noise_e, rounding_e),
                              exposure.black_dn};
    std::vector<double> from = start;
    if (std::isnan(from.front())) from.assign(from.size(), 0.0);
    const auto done = refiner_->refine(exposure.view(), camera, from);
    std::vector<double> waves(start.size(), NAN);
    for (std::size_t k = 0; done && k < waves.size(); ++k) waves[k] = done->modes[k].waves;
    return waves;
  }

  const Tools& tools_;
  SensorConfig sensor_;
  std::shared_ptr<SensorModel> model_;
  std::unique_ptr<Refiner> refiner_;
};

/// Root sum square over all modes of measured minus true, waves.
double error_of(const std::vector<double>& found, const std::vector<int>& modes_j,
                const std::vector<Mode>& truth) {
  double squares = 0.0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    double error = found[k];
    for (const Mode& mode : truth) error -= mode.j == modes_j[k] ? mode.waves : 0.0;
    squares += error * error;
  }
  return std::sqrt(squares);
}

}  // namespace

Findings operators(const Settings& settings) {
  const std::vector<double> amplitudes =
      settings.quick ? std::vector<double>{0.1, 0.3} : std::vector<double>{0.05, 0.1, 0.2, 0.3};
  std::vector<int> modes_j;
  for (int j = 3; j <= 18; j += settings.quick ? 5 : 1) modes_j.push_back(j);
  const Tools tools;
  const std::size_t per_noise = amplitudes.size() * modes_j.size();
  std::vector<Readings> readings(2 * per_noise);
  const auto truth_of = [&](std::size_t k) {
    return std::vector<Mode>{
        {modes_j[k % modes_j.size()], amplitudes[k % per_noise / modes_j.size()]}};
  };
  parallel_for("operators", readings.size(), settings.threads, [&](std::size_t k) {
    const double read_noise_e = k < per_noise ? 0.0 : read_noise_of_snr(kSnr);
    readings[k] = Bench(tools).read(truth_of(k), read_noise_e, settings.seed + k);
  });
  nlohmann::json summary{{"study", "operators"},
                         {"unit", "waves, root sum square over all modes"},
                         {"snr", kSnr},
                         {"rows", nlohmann::json::array()}};
  Figure figure{
      "operators",
      fmt::format("Single modes at {} wave, SNR {}, by operator", amplitudes.back(), kSnr),
      "OSA index j of the mode shown",
      "error of all modes (waves)",
      false,
      true,
      false,
      {}};
  for (std::size_t o = 0; o < kOperators.size(); ++o) {
    Series series{kOperators[o], {}, {}, {}};
    for (std::size_t k = 0; k < readings.size(); ++k) {
      const auto truth = truth_of(k);
      const double error = error_of(readings[k][o], tools.measurer.modes_j(), truth);
      const bool noisy = k >= per_noise;
      summary["rows"].push_back({{"operator", kOperators[o]},
                                 {"j", truth.front().j},
                                 {"waves", truth.front().waves},
                                 {"noisy", noisy},
                                 {"error_waves", error}});
      if (!noisy || truth.front().waves != amplitudes.back()) continue;
      series.x.push_back(truth.front().j);
      series.y.push_back(error);
    }
    figure.series.push_back(std::move(series));
  }
  return {std::move(summary), {std::move(figure)}};
}

}  // namespace ovws::study
