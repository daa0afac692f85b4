#include "drivers/twin/bench_model.hpp"

#include <Eigen/Core>
#include <numbers>

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
  far_field_.emplace(config_.slm.geometry, far_field_window(config_.sensor, config_.slm.geometry,
                                                            optics, window.width, window.height));
}

Image<float> BenchModel::intensity(const Image<std::uint8_t>& grey) {
  slm_.modulate(grey, field_);
  far_field_->propagate(field_, far_);
  Image<float> intensity(far_.width, far_.height);
  const float scale = float(1.0 / unit_);
  for (std::size_t i = 0; i < far_.pixels.size(); ++i) {
    const float re = far_.pixels[i].real(), im = far_.pixels[i].imag();
    intensity.pixels[i] = scale * (re * re + im * im);
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
