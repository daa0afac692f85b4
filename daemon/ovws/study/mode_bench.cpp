#include "daemon/ovws/study/mode_bench.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "core/base/decompositions.hpp"
#include "core/spots/wavefront_fit.hpp"
#include "daemon/ovws/study/fitting.hpp"
#include "daemon/ovws/study/statistics.hpp"

namespace ovws::study {
namespace {

constexpr int kTilts = 2;               // tip and tilt, the first modes: left out of the errors
constexpr double kConditioning = 1e-9;  // least reciprocal condition number of normal equations

/// Sum of |F|^2 over the camera's pixels for all subapertures together, by Parseval's theorem.
double light_of_all(const Geometry& geometry, int subapertures) {
  const double d_px = geometry.sensor.pupil_diameter_px / geometry.sensor.subapertures_across;
  const double px_per_cycle = camera_px_per_cycle(geometry.optics, geometry.slm);
  return subapertures * 0.25 * std::numbers::pi * d_px * d_px * px_per_cycle * px_per_cycle;
}

Image<float> flat_light_e(const Geometry& geometry, Light level) {
  const auto model = model_of(geometry, geometry.sensor.charge);
  Image<float> light = value_of(model->intensity({}));
  scale(light, level == Light::equal_peak
                   ? kPeakE / model->peak_of_spots(light, {})
                   : kPhotonsE / light_of_all(geometry, int(model->spots_px().size())));
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
  const Cholesky factors(normal);
  if (!(factors.reciprocal_condition() > kConditioning)) return std::nullopt;
  return WavefrontStep{factors.solve(right), factors.inverse()};
}

void take(const std::optional<WavefrontStep>& step, std::vector<double>& squares,
          double& expected) {
  if (!step) return;
  squares.push_back(step->waves.tail(step->waves.size() - kTilts).squaredNorm());
  expected = without_tilts(step->covariance);
}

}  // namespace

nlohmann::json head_of_modes(const std::string& study) {
  return {{"study", study},
          {"unit", "waves"},
          {"peak_e", kPeakE},
          {"photons_e", kPhotonsE},
          {"read_noise_e", kModesReadNoiseE}};
}

nlohmann::json measure_modes(const Geometry& geometry, Light light, int modes, int images,
                             std::uint64_t seed) {
  const std::vector<int> modes_j = first_modes_j(modes);
  const Image<float> light_e = flat_light_e(geometry, light);
  SpotRenderer renderer = renderer_of(geometry, geometry.sensor.charge, modes_j);
  const std::vector<double> flat(modes_j.size(), 0.0);
  const std::vector<RenderedSpot> rendered = renderer.render(flat);
  std::vector<double> shapes, positions;
  double shapes_expected = kUnknown, positions_expected = kUnknown;
  for (int k = 0; k < images; ++k) {
    const Exposure exposure = expose(light_e, kModesReadNoiseE, seed + unsigned(k));
    const SpotPass pass = fit_spots(exposure.view(), rendered, noise_of(exposure, kModesReadNoiseE),
                                    kMaxSpotEstimates);
    take(step_from(pass), shapes, shapes_expected);
    take(step_from_positions(pass, rendered), positions, positions_expected);
  }
  const Mean by_shapes = root_of(shapes), by_positions = root_of(positions);
  return {{"bound_waves", number_or_null(bound_of(geometry, light_e, modes_j))},
          {"shapes_waves", number_or_null(by_shapes.value)},
          {"shapes_standard_error_waves", by_shapes.standard_error},
          {"shapes_expected_waves", number_or_null(shapes_expected)},
          {"positions_waves", number_or_null(by_positions.value)},
          {"positions_standard_error_waves", by_positions.standard_error},
          {"positions_expected_waves", number_or_null(positions_expected)},
          {"images", by_shapes.count}};
}

}  // namespace ovws::study
