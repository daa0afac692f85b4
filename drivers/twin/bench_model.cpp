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

/// Runs work(first, end, worker) on the two halves of the range 0 .. count - 1 in parallel.
template <class Work>
void in_halves(int count, const Work& work) {
  const std::jthread helper([&] { work(count / 2, count, 1); });
  work(0, count / 2, 0);
}

}  // namespace

BenchModel::BenchModel(const Config& config)
    : config_(config),
      slm_(config),
      unit_(vortex_peak_intensity(config.sensor)),
      slm_field_(config.slm.geometry.width_px, config.slm.geometry.height_px) {}

void BenchModel::set_window(const Roi& window, const CameraGeometry& geometry) {
  const SlmGeometry& slm = config_.slm.geometry;
  view_.emplace(camera_map(config_, geometry), slm, window);
  far_field_.emplace(slm, view_->grid(), 2);
  far_ = {view_->grid().cols, view_->grid().rows};
  pixel_field_ = {window.width, window.height};
}

const Image<std::complex<float>>& BenchModel::field(const Image<std::uint8_t>& grey) {
  in_halves(slm_field_.height, [&](int first, int end, int worker) {
    slm_.modulate(grey, first, end, slm_field_);
    far_field_->transform_rows(slm_field_, first, end, worker);
  });
  in_halves(far_.width, [&](int first, int end, int worker) {
    far_field_->transform_columns(first, end, worker, far_);
  });
  in_halves(pixel_field_.height,
            [&](int first, int end, int) { view_->read(far_, first, end, pixel_field_); });
  return pixel_field_;
}

Image<float> BenchModel::intensity(const Image<std::uint8_t>& grey) {
  const Image<std::complex<float>>& pixel_field = field(grey);
  Image<float> intensity(pixel_field.width, pixel_field.height);
  const float scale = float(1.0 / unit_);
  for (std::size_t i = 0; i < pixel_field.pixels.size(); ++i) {
    const float re = pixel_field.pixels[i].real(), im = pixel_field.pixels[i].imag();
    intensity.pixels[i] = scale * (re * re + im * im);
  }
  return intensity;
}

std::vector<Vec2> true_spots_px(const Config& config, const Truth& truth) {
  const auto lattice = make_lattice(config.sensor, config.slm.geometry);
  if (!lattice) return {};
  std::vector<int> modes_j;
  Eigen::VectorXd waves(Eigen::Index(truth.aberration.size()));
  for (const Mode& mode : truth.aberration) {
    waves[Eigen::Index(modes_j.size())] = mode.waves;
    modes_j.push_back(mode.j);
  }
  // Slope matrix at 1 camera pixel per cycle: its displacements are in cycles per SLM pixel.
  const Eigen::VectorXd moved_cpp =
      slope_matrix(*lattice, config.sensor, modes_j,
                   config.sensor.charge == 0 ? kGradientTilt : kVortexTilt, 1.0) *
      waves;
  const CameraMap map = camera_map(config, truth.geometry);
  std::vector<Vec2> spots;
  for (const Subaperture& s : lattice->subapertures) {
    const auto i = Eigen::Index(2 * spots.size());
    spots.push_back(map.pixel(s.frequency_cpp + Vec2{moved_cpp[i], moved_cpp[i + 1]}));
  }
  return spots;
}

}  // namespace ovws::twin
