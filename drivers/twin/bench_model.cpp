#include "drivers/twin/bench_model.hpp"

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <thread>

#include "core/optics/lattice.hpp"
#include "core/wavefront/slope_model.hpp"

namespace ovws::twin {
namespace {

double vortex_peak_intensity(const SensorConfig& sensor) {
  const double radius = sensor.pupil_diameter_px / sensor.subapertures_across / 2.0;
  const double peak = kVortexPeak * std::numbers::pi * radius * radius;
  return peak * peak;
}

}  // namespace

BenchModel::BenchModel(const Config& config)
    : config_(config), slm_(config), unit_(vortex_peak_intensity(config.sensor)) {}

void BenchModel::set_window(const Roi& window) {
  OpticsConfig optics = config_.optics;
  optics.centre_px = *optics.centre_px - Vec2{double(window.x), double(window.y)};
  const SlmGeometry& slm = config_.slm.geometry;
  const FarFieldWindow looked_at =
      far_field_window(config_.sensor, slm, optics, window.width, window.height);
  halves_.clear();
  SlmGeometry upper = slm, lower = slm;
  upper.height_px = slm.height_px / 2;
  lower.height_px = slm.height_px - upper.height_px;
  halves_.push_back({0, FarField(upper, looked_at), {slm.width_px, upper.height_px}, {}});
  halves_.push_back(
      {upper.height_px, FarField(lower, looked_at), {slm.width_px, lower.height_px}, {}});
  // The middles of two halves are half of the whole apart, however it was cut.
  between_.resize(std::size_t(looked_at.rows));
  for (int r = 0; r < looked_at.rows; ++r) {
    const double v = looked_at.origin_cpp.y + r * looked_at.step_cpp;
    const double angle = -std::numbers::pi * std::remainder(v * slm.height_px, 2.0);
    between_[std::size_t(r)] = {float(std::cos(angle)), float(std::sin(angle))};
  }
}

void BenchModel::propagate(const Image<std::uint8_t>& grey, Half& half) const {
  slm_.modulate(grey, half.first_row, half.field);
  half.far_field.propagate(half.field, half.far);
}

Image<float> BenchModel::intensity(const Image<std::uint8_t>& grey) {
  Half& upper = halves_.front();
  Half& lower = halves_.back();
  std::jthread helper([&] { propagate(grey, lower); });
  propagate(grey, upper);
  helper.join();
  Image<float> intensity(upper.far.width, upper.far.height);
  const float scale = float(1.0 / unit_);
  for (int r = 0; r < intensity.height; ++r) {
    const std::complex<float> turn = between_[std::size_t(r)];
    const std::complex<float>*up = upper.far.row(r), *low = lower.far.row(r);
    float* out = intensity.row(r);
    for (int c = 0; c < intensity.width; ++c) {
      // By hand, as in SlmModel::modulate.
      const float re = up[c].real() + turn.real() * low[c].real() - turn.imag() * low[c].imag();
      const float im = up[c].imag() + turn.real() * low[c].imag() + turn.imag() * low[c].real();
      out[c] = scale * (re * re + im * im);
    }
  }
  return intensity;
}

std::vector<Vec2> true_spots_px(const Config& config, std::span<const Mode> aberration) {
  const SlmGeometry& slm = config.slm.geometry;
  const auto lattice = make_lattice(config.sensor, slm);
  if (!lattice) return {};
  std::vector<Vec2> spots = model_spots_px(*lattice, config.sensor, slm, config.optics,
                                           config.camera.sensor_width, config.camera.sensor_height);
  if (aberration.empty()) return spots;

  std::vector<int> modes_j;
  Eigen::VectorXd waves(Eigen::Index(aberration.size()));
  for (const Mode& mode : aberration) {
    waves[Eigen::Index(modes_j.size())] = mode.waves;
    modes_j.push_back(mode.j);
  }
  const Eigen::VectorXd moved =
      slope_matrix(*lattice, config.sensor, modes_j, slope_kind(config.sensor.charge),
                   camera_px_per_cycle(config.optics, slm)) *
      waves;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    spots[i] = spots[i] + Vec2{moved[Eigen::Index(2 * i)], moved[Eigen::Index(2 * i + 1)]};
  }
  return spots;
}

}  // namespace ovws::twin
