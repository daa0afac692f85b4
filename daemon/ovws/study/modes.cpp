/// Study `modes`: how many modes a lattice of spots determines, and how accurately: by the spots'
/// positions, by their shapes, and by the Cramer-Rao bound.
#include <spdlog/fmt/fmt.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "core/optics/lattice.hpp"
#include "core/spots/wavefront_fit.hpp"
#include "daemon/ovws/study/figure.hpp"
#include "daemon/ovws/study/fitting.hpp"
#include "daemon/ovws/study/sensor.hpp"
#include "daemon/ovws/study/statistics.hpp"
#include "daemon/ovws/study/studies.hpp"
#include "daemon/ovws/study/wavefront_bound.hpp"

namespace ovws::study {
namespace {

/// Normalisation of the light at which lattices and charges are compared.
enum class Budget {
  peak,    ///< kPeakE in the brightest pixel: the camera's full well is the limit
  photons  ///< kPhotonsE in all spots together: the laser is the limit
};
constexpr double kPhotonsE = 19 * 20'000.0;
constexpr double kModesReadNoiseE = 5.0;

struct ModeCase {
  int subapertures = 19;  ///< 19, 37 or 61
  int charge = 1;
  int modes = 18;  ///< number of modes: j = 1 to `modes`
  Budget budget = Budget::peak;
};

/// Errors for a flat wavefront: root sum square over all modes but the tilts, waves.
struct ModeErrors {
  double bound = kUnknown;               ///< Cramer-Rao bound from all pixels of the image
  Mean shapes;                           ///< measured with templates of every spot
  double shapes_expected = kUnknown;     ///< expected error of `shapes`, from the covariance
  Mean positions;                        ///< measured with the positions of the same spots only
  double positions_expected = kUnknown;  ///< expected; NaN: positions do not determine the modes
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ModeErrors, bound, shapes, shapes_expected, positions,
                                   positions_expected)

constexpr int kTilts = 2;               // tip and tilt, the first modes: left out of the errors
constexpr double kConditioning = 1e-9;  // least reciprocal condition number of normal equations

/// Bench with 19, 37 or 61 subapertures. The spots are as bright and as far apart (in lambda/d) as
/// on the default bench; a smaller magnification keeps them in the image.
Geometry bench_of(int subapertures, int charge) {
  Geometry geometry = default_bench();
  geometry.sensor.charge = charge;
  if (subapertures == 37) {
    geometry.sensor.subapertures_across = 7;
    geometry.sensor.spacing = 0.49;
    geometry.sensor.grooves = {300.0, 25.0};
    geometry.optics.magnification = 0.6;
  } else if (subapertures == 61) {
    geometry.sensor.subapertures_across = 9;
    geometry.sensor.spacing = 0.81;
    geometry.sensor.grooves = {340.0, 130.0};
    geometry.optics.magnification = 0.36;
  }
  return geometry;
}

/// Sum of |F|^2 over the camera's pixels for all subapertures together, by Parseval's theorem.
double light_of_all(const Geometry& geometry, int subapertures) {
  const double d_px = geometry.sensor.pupil_diameter_px / geometry.sensor.subapertures_across;
  const double px_per_cycle = camera_px_per_cycle(geometry.optics, geometry.slm);
  return subapertures * 0.25 * std::numbers::pi * d_px * d_px * px_per_cycle * px_per_cycle;
}

Image<float> flat_light_e(const Geometry& geometry, const ModeCase& one) {
  const auto model = model_of(geometry, one.charge);
  if (int(model->spots_px().size()) != one.subapertures) {
    throw std::logic_error("the study has no lattice of so many subapertures");
  }
  Image<float> light = value_of(model->intensity({}));
  scale(light, one.budget == Budget::peak ? kPeakE / model->peak_of_spots(light, {})
                                          : kPhotonsE / light_of_all(geometry, one.subapertures));
  return light;
}

double without_tilts(const Eigen::MatrixXd& covariance) {
  return std::sqrt(covariance.diagonal().tail(covariance.rows() - kTilts).sum());
}

double bound_of(const Geometry& geometry, const Image<float>& light_e,
                const std::vector<int>& modes_j) {
  SpotRenderer renderer = bound_renderer_of(geometry, geometry.sensor.charge, modes_j);
  return without_tilts(pixel_covariance(renderer, {}, light_e, kModesReadNoiseE));
}

/// Shift of the spot position from the templates per wave of each mode; a matrix of 2 x modes.
Eigen::MatrixXd moved_by(const SpotTemplates& spot, const RenderedSpot& rendered) {
  const auto rows = spot.rows.middleRows(SpotTemplates::kX, 2).leftCols(rendered.light.size());
  return rows.cast<double>() * rendered.per_wave.cast<double>();
}

/// Covariance of the spot position from the templates, times the squared level of the bins.
Eigen::Matrix2d scatter_of(const SpotTemplates& spot) {
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (Eigen::Index c = 0; c < spot.weights.size(); ++c) {
    if (!(spot.weights(c) > 0.0F)) continue;
    const Eigen::Vector2d row = spot.rows.col(c).segment<2>(SpotTemplates::kX).cast<double>();
    scatter += row * row.transpose() / double(spot.weights(c));
  }
  return scatter;
}

/// Weighted least-squares fit of the modes to the spots' positions. None if the positions do not
/// determine the modes.
std::optional<WavefrontStep> step_from_positions(const SpotPass& pass,
                                                 std::span<const RenderedSpot> rendered) {
  const Eigen::Index modes = rendered.front().per_wave.cols();
  if (2 * Eigen::Index(rendered.size()) < modes) return std::nullopt;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(modes, modes);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(modes);
  for (std::size_t i = 0; i < rendered.size(); ++i) {
    const SpotEstimates& found = pass.found[i];
    const SpotTemplates& spot = pass.templates[i];
    if (!(found.level > 0.0F)) continue;
    const Eigen::MatrixXd moved = moved_by(spot, rendered[i]);
    const double level = double(found.level) * spot.window.bin * spot.window.bin;
    const Eigen::Matrix2d weight = level * level * scatter_of(spot).inverse();
    const Eigen::Vector2d at(double(found.x) - spot.place_px.x, double(found.y) - spot.place_px.y);
    normal += moved.transpose() * weight * moved;
    right += moved.transpose() * weight * at;
  }
  const Eigen::LLT<Eigen::MatrixXd> solver(normal);
  if (solver.info() != Eigen::Success || !(solver.rcond() > kConditioning)) return std::nullopt;
  return WavefrontStep{solver.solve(right), solver.solve(Eigen::MatrixXd::Identity(modes, modes))};
}

void take(const std::optional<WavefrontStep>& step, std::vector<double>& squares,
          double& expected) {
  if (!step) return;
  squares.push_back(step->waves.tail(step->waves.size() - kTilts).squaredNorm());
  expected = without_tilts(step->covariance);
}

const char* name_of(Budget budget) {
  return budget == Budget::peak ? "equal peak" : "equal photons";
}

/// Measures the mode errors in `images` noisy images. The same seed gives the same numbers.
ModeErrors measure_modes(const ModeCase& one, int images, std::uint64_t seed) {
  const Geometry geometry = bench_of(one.subapertures, one.charge);
  const std::vector<int> modes_j = first_modes_j(one.modes);
  const Image<float> light_e = flat_light_e(geometry, one);
  ModeErrors errors;
  errors.bound = bound_of(geometry, light_e, modes_j);
  SpotRenderer renderer = renderer_of(geometry, one.charge, modes_j);
  const std::vector<double> flat(modes_j.size(), 0.0);
  const std::vector<RenderedSpot> rendered = renderer.render(flat);
  std::vector<double> shapes, positions;
  for (int k = 0; k < images; ++k) {
    const Exposure exposure = expose(light_e, kModesReadNoiseE, seed + unsigned(k));
    const SpotPass pass = fit_spots(exposure.view(), rendered, noise_of(exposure, kModesReadNoiseE),
                                    kMaxSpotEstimates);
    take(step_from(pass), shapes, errors.shapes_expected);
    take(step_from_positions(pass, rendered), positions, errors.positions_expected);
  }
  errors.shapes = root_of(shapes);
  errors.positions = root_of(positions);
  return errors;
}

constexpr std::array<int, 4> kModes{18, 27, 35, 44};
constexpr std::array<Budget, 2> kBudgets{Budget::peak, Budget::photons};

std::vector<ModeCase> cases_of(const Settings& settings) {
  std::vector<ModeCase> cases;
  for (const int subapertures : {19, 37, 61}) {
    for (const int charge : {1, 0, 2}) {
      if (settings.quick && (subapertures != 19 || charge == 2)) continue;
      for (const Budget budget : kBudgets) {
        for (const int modes : kModes) cases.push_back({subapertures, charge, modes, budget});
      }
    }
  }
  return cases;
}

std::string sensor_name(int charge) {
  return charge == 0 ? "Shack-Hartmann" : charge == 1 ? "vortex" : "vortex of charge 2";
}

nlohmann::json row_of(const ModeCase& one, const ModeErrors& errors) {
  return {{"subapertures", one.subapertures},
          {"charge", one.charge},
          {"modes", one.modes},
          {"light", name_of(one.budget)},
          {"bound_waves", errors.bound},
          {"shapes_waves", errors.shapes.value},
          {"shapes_standard_error_waves", errors.shapes.standard_error},
          {"shapes_expected_waves", errors.shapes_expected},
          {"positions_waves", errors.positions.value},
          {"positions_standard_error_waves", errors.positions.standard_error},
          {"positions_expected_waves", errors.positions_expected},
          {"images", errors.shapes.count}};
}

/// Figure of one lattice at one light level: errors by shapes and by positions for every charge,
/// and the Cramer-Rao bound.
Figure figure_of(int subapertures, Budget budget, const std::vector<ModeCase>& cases,
                 const std::vector<ModeErrors>& errors) {
  Figure figure{fmt::format("modes-{}{}", subapertures, budget == Budget::peak ? "" : "-photons"),
                fmt::format("{} subapertures, flat wavefront, {}", subapertures, name_of(budget)),
                "modes measured", "error without tilts (waves RMS)"};
  figure.log_y = true;
  for (const int charge : {1, 0, 2}) {
    Series shapes{sensor_name(charge) + ", shapes", {}, {}, {}};
    Series positions{sensor_name(charge) + ", positions", {}, {}, {}};
    Series bound{sensor_name(charge) + ", bound", {}, {}, {}, Series::Style::line};
    for (std::size_t k = 0; k < cases.size(); ++k) {
      const ModeCase& one = cases[k];
      if (one.subapertures != subapertures || one.budget != budget || one.charge != charge)
        continue;
      const ModeErrors& found = errors[k];
      if (found.shapes.count > 0) shapes.add(one.modes, found.shapes);
      if (found.positions.count > 0) positions.add(one.modes, found.positions);
      bound.add(one.modes, found.bound);
    }
    for (Series* series : {&shapes, &positions, &bound}) {
      if (!series->x.empty()) figure.series.push_back(std::move(*series));
    }
  }
  return figure;
}

Findings findings_of(const std::vector<ModeCase>& cases, const std::vector<ModeErrors>& errors,
                     bool quick) {
  Findings findings;
  findings.summary = {{"study", "modes"},
                      {"unit", "waves"},
                      {"peak_e", kPeakE},
                      {"photons_e", kPhotonsE},
                      {"read_noise_e", kModesReadNoiseE},
                      {"rows", nlohmann::json::array()}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    findings.summary["rows"].push_back(row_of(cases[k], errors[k]));
  }
  for (const int subapertures : {19, 37, 61}) {
    if (quick && subapertures != 19) continue;
    for (const Budget budget : kBudgets) {
      findings.figures.push_back(figure_of(subapertures, budget, cases, errors));
    }
  }
  return findings;
}

}  // namespace

Work modes(const Settings& settings) {
  const int images = settings.quick ? 20 : 100;
  const std::vector<ModeCase> cases = cases_of(settings);
  return work_of(
      cases.size(),
      [cases, images, seed = settings.seed](std::size_t k) {
        return measure_modes(cases[k], images, seed + 1000 * k);
      },
      [cases, quick = settings.quick](const std::vector<ModeErrors>& errors) {
        return findings_of(cases, errors, quick);
      });
}

}  // namespace ovws::study
